// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/constraint.h"

namespace gelenk {

// Rack and pinion: s_rack = radius phi_pinion + offset.
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

  double radius = 1;  // m
  double offset = 0;  // m

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Rack::radius>({.name = "radius",
                              .unit = "m",
                              .text = "travel of the rack per radian of the pinion",
                              .range = Range::not_zero,
                              .required = true}),
        field<&Rack::offset>({.name = "offset", .unit = "m", .text = "position of the rack when the pinion is at 0"})};
    return all;
  }
  static constexpr SignalGroup outputs[] = {{"f", 0, "N", "force of the pinion on joint {joint}"}};

  template <class OnBase>
  double factor(int i, const OnBase&) const {
    return i == 0 ? 1 : -radius;
  }
  double constant() const { return offset; }
  template <class Seen>
  auto output(const Seen& seen, int, int) const {
    return seen.coordinate_force();
  }
};

}  // namespace gelenk
