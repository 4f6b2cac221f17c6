// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "element/constraints/constraint.h"
#include "element/constraints/mesh_losses.h"

namespace gelenk {

// Rack and pinion: s_rack = radius phi_pinion + offset. Losses are friction of the pinion.
struct Rack {
  static constexpr std::string_view kind = "rack";
  static constexpr std::string_view summary = "a rack translates as its pinion rotates";
  static constexpr Port ports[] = {
      {.kind = Port::Kind::joint,
       .name = "rack",
       .text = "Joint that translates",
       .fits = [](const JointKind& kind) { return kind.nq == 1 && kind.nv == 1 && kind.q[0].unit == "m"; }},
      {.kind = Port::Kind::joint, .name = "pinion", .text = "Joint that rotates", .fits = [](const JointKind& kind) {
         return kind.nq == 1 && kind.nv == 1 && kind.q[0].unit == "rad";
       }}};

  double radius = 1;                // m
  double offset = 0;                // m
  Formula efficiency, backdriving;  // see MeshLosses

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Rack::radius>({.name = "radius",
                              .unit = "m",
                              .text = "travel of the rack per radian of the pinion",
                              .range = Range::not_zero,
                              .required = true}),
        field<&Rack::offset>({.name = "offset", .unit = "m", .text = "position of the rack when the pinion is at 0"}),
        field<&Rack::efficiency>(
            MeshLosses::efficiency_info("part of the power that leaves the mesh if `pinion` drives `rack`, 1 if not "
                                        "given; may be an expression of the speed w and the torque tau")),
        field<&Rack::backdriving>(
            MeshLosses::backdriving_info("part of the power that leaves the mesh if `rack` drives `pinion`; 0 or less: "
                                         "it cannot; may be an expression of the speed w and the torque tau"))};
    return all;
  }
  static constexpr SignalGroup outputs[] = {{"f", 0, "N", "force of the pinion on joint {joint}"}};

  template <class OnBase>
  double factor(int i, const OnBase&) const {
    return i == 0 ? 1 : -radius;
  }
  double constant() const { return offset; }
  static constexpr int lossy_joint = 1;
  MeshLosses losses() const { return {efficiency, backdriving}; }
  std::optional<ElementFault> fault(const Coordinate&) const { return losses().fault(); }
  template <class Seen>
  auto output(const Seen& seen, int, int) const {
    return seen.coordinate_force();
  }
};

}  // namespace gelenk
