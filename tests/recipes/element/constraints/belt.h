// SPDX-License-Identifier: BSD-3-Clause
// Example of a constraint between joint coordinates; tests/test_recipes.py adds it.
#pragma once

#include "element/constraints/constraint.h"

namespace gelenk {

// radius phi_joint = other_radius phi_with.
struct Belt {
  static constexpr std::string_view kind = "belt";
  static constexpr std::string_view summary = "a belt couples the rotation of two joints";
  static constexpr auto turns = [](const JointKind& kind) {
    return kind.nq == 1 && kind.nv == 1 && kind.q[0].unit == "rad";
  };
  static constexpr Port ports[] = {
      {.kind = Port::Kind::joint, .name = "joint", .text = "First rotating joint", .fits = turns},
      {.kind = Port::Kind::joint, .name = "with", .text = "Second rotating joint", .fits = turns}};

  double radius = 1, other_radius = 1;  // m

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Belt::radius>({.name = "radius",
                              .unit = "m",
                              .text = "radius of the pulley at {joint}",
                              .range = Range::positive,
                              .required = true}),
        field<&Belt::other_radius>(
            {.name = "other_radius", .unit = "m", .text = "radius of the other pulley", .range = Range::positive})};
    return all;
  }
  static constexpr SignalGroup outputs[] = {{"tau", 0, "N.m", "torque of the belt on joint {joint}"}};

  template <class OnBase>
  double factor(int i, const OnBase&) const {
    return i == 0 ? 1 : -other_radius / radius;
  }
  template <class Seen>
  auto output(const Seen& seen, int, int) const {
    return seen.coordinate_force();
  }
};

}  // namespace gelenk
