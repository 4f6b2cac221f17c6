// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "element/joint_forces/coordinate_force.h"
#include "util/text.h"

namespace gelenk {

// Hard limits of a joint coordinate, a set-valued law (Moreau 1988): at a bound the force takes the value, never
// pulling, that keeps the coordinate within it; an impact with the speed v ends with -restitution v (Newton); or
// its impulse is 1 + restitution times that which ends the approach (Poisson). Both differ only where several bounds
// are struck together.
struct JointLimit {
  static constexpr std::string_view group = "limit";
  static constexpr std::string_view summary = "hard limits of the coordinate, with impacts";
  static constexpr std::string_view misfit =
      "has no angles or lengths that it could act on";  // of a joint with coordinates
  static bool fits(const JointKind& kind) { return kind.springs(); }

  double lower = -std::numeric_limits<double>::infinity();  // rad (m); infinite if there is no bound
  double upper = std::numeric_limits<double>::infinity();   // rad (m)
  double restitution = 0;
  static constexpr std::string_view laws[] = {"newton", "poisson"};
  Choice law = {0};  // index in laws

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&JointLimit::lower>({.name = "lower",
                                   .unit = "{q}",
                                   .text = "lower bound of its hard limit, on {coordinate}",
                                   .optional = true,
                                   .alternative = 1}),
        field<&JointLimit::upper>({.name = "upper",
                                   .unit = "{q}",
                                   .text = "upper bound of its hard limit, on {coordinate}",
                                   .optional = true,
                                   .alternative = 1}),
        field<&JointLimit::restitution>({.name = "restitution",
                                         .unit = "1",
                                         .text = "coefficient of restitution of its hard limit, on {coordinate}",
                                         .range = Range::fraction,
                                         .tunable = true}),
        field<&JointLimit::law>({.name = "law", .text = "law of impact of its hard limit", .words = laws})};
    return all;
  }

  bool is_poisson() const { return law.index == 1; }

  static constexpr SignalGroup outputs[] = {
      {"{effort}", 0, "{f}",
       "contact {torque} on {joint}.{coordinate} at a limit, in its direction; impacts count in time steps alone"},
      {"mode", 0, "1", "1, -1: {joint}.{coordinate} is in contact with its upper, lower limit; 0: with none"}};

  std::optional<ElementFault> fault(const Coordinate& at) const { return fault_of_bounds(lower, upper, at); }

  // How far q is beyond the upper (side 1) or the lower bound (side -1) [rad, m]; negative within it.
  double depth(int side, double q) const { return side > 0 ? q - upper : lower - q; }
  // Positions this close to a bound touch it: some tens of roundings of the loops' closure.
  double touch_tolerance(int side) const {
    const double bound = side > 0 ? upper : lower;
    return std::isfinite(bound) ? 1e-12 * std::max(1.0, std::abs(bound)) : 0;
  }

  // Modes: 1 and -1 in contact at the upper and the lower bound, where the equations of motion determine the force
  // (dynamics/locked_coordinates.h); otherwise 0.
  template <class T>
  T held(int, const T&, const T&, const T*) const {
    return T(0);
  }
  template <class T>
  int side(const T& q, const T&) const {
    return q > T(upper) ? 1 : q < T(lower) ? -1 : 0;
  }
  template <class T>
  T effort(const T&, const T&, const T*) const {
    return T(0);
  }
  // The event indicators in a mode: of contact at the upper and the lower bound. x: in contact, the force that keeps
  // the coordinate at rest. adhesion: how far x may pull, by friction.
  void indicators(int side, double q, double v, double x, double adhesion, double* g, double* gdot) const {
    for (const int bound : {1, -1}) {
      *g++ = side == 0 ? depth(bound, q) : side == bound ? adhesion - side * x : -1;
      *gdot++ = side == 0 ? bound * v : NAN;
    }
  }
  // For each indicator, the texts of the events at which contact ends and begins.
  static constexpr std::string_view events[2][2] = {
      {"{joint}.{coordinate} leaves its upper limit", "{joint}.{coordinate} meets its upper limit"},
      {"{joint}.{coordinate} leaves its lower limit", "{joint}.{coordinate} meets its lower limit"}};
};

}  // namespace gelenk
