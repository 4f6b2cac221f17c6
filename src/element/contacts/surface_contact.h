// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include "element/contacts/contact.h"
#include "util/text.h"

namespace gelenk {

// Contact of all shapes with one surface with all shapes with another: no penetration, Coulomb friction in a circular
// cone, rolling and spinning friction as moments of at most a length times the normal force, and Newton's law of
// impact. All of them are set-valued (Acary & Brogliato 2008, ch. 3).
struct SurfaceContact {
  static constexpr std::string_view kind = "contact";
  static constexpr std::string_view summary = "contact of two surfaces, with dry friction and impacts";
  static constexpr Port ports[] = {
      {.kind = Port::Kind::surfaces, .name = "between", .text = "The two surfaces, which may be the same"}};

  double friction = 0;
  double static_friction = std::numeric_limits<double>::quiet_NaN();  // NaN: that of sliding
  double rolling = 0;                                                 // m
  double spinning = 0;                                                // m
  double restitution = 0;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  // m/s
  bool adjacent = false;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&SurfaceContact::friction>({.name = "friction",
                                          .unit = "1",
                                          .text = "coefficient of sliding friction",
                                          .range = Range::not_negative,
                                          .tunable = true}),
        field<&SurfaceContact::static_friction>(
            {.name = "static",
             .unit = "1",
             .text = "coefficient of static friction; that of sliding friction if not given",
             .range = Range::not_negative,
             .optional = true,
             .tunable = true}),
        field<&SurfaceContact::rolling>({.name = "rolling",
                                         .unit = "m",
                                         .text = "largest moment of rolling friction per normal force",
                                         .range = Range::not_negative,
                                         .tunable = true}),
        field<&SurfaceContact::spinning>({.name = "spinning",
                                          .unit = "m",
                                          .text = "largest moment of spinning friction per normal force",
                                          .range = Range::not_negative,
                                          .tunable = true}),
        field<&SurfaceContact::restitution>({.name = "restitution",
                                             .unit = "1",
                                             .text = "coefficient of restitution of impacts",
                                             .range = Range::fraction,
                                             .tunable = true}),
        field<&SurfaceContact::velocity>(
            {.name = "velocity",
             .unit = "m/s",
             .text = "velocity of the second surface relative to its body, as of a belt, in the axes of its shape",
             .tunable = true}),
        field<&SurfaceContact::adjacent>({.name = "adjacent",
                                          .text = "whether bodies that share a joint can touch, too; those on joints "
                                                  "to the ground always can touch it"})};
    return all;
  }

  static constexpr SignalGroup outputs[] = {
      {"f", 3, "N",
       "contact force on the bodies with its first surface, resolved in the world; impacts count in time steps alone"},
      {"gap", 0, "m", "smallest distance of its surfaces, negative if they penetrate"},
      {"mode", 0, "1", "0: no contact; 1: all contact points stick; 2: some of them slide"}};

  std::optional<ElementFault> fault(const Coordinate&) const {
    if (!(static_friction < friction)) return {};
    return ElementFault{.field = "static",
                        .found = text::number(static_friction),
                        .expected = "at least the coefficient of sliding friction, " + text::number(friction)};
  }

  ContactLaw law() const {
    return {friction, std::isfinite(static_friction) ? static_friction : friction, rolling, spinning, restitution,
            velocity};
  }

  double output(const SeenContact& seen, int group, int i) const {
    return group == 0 ? seen.force()[i] : group == 1 ? seen.gap() : seen.mode();
  }
};

}  // namespace gelenk
