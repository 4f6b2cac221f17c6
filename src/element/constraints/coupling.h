// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/constraints/constraint.h"

namespace gelenk {

// q_joint = ratio q_with + offset, for two joints that both rotate or both translate.
struct Coupling {
  static constexpr std::string_view kind = "coupling";
  static constexpr std::string_view summary = "two joints move at a fixed ratio; both rotate or both translate";
  static constexpr auto has_one_coordinate = [](const JointKind& kind) { return kind.nq == 1 && kind.nv == 1; };
  static constexpr Port ports[] = {
      {.kind = Port::Kind::joint, .name = "joint", .text = "Joint that follows", .fits = has_one_coordinate},
      {.kind = Port::Kind::joint,
       .name = "with",
       .text = "Joint that it follows, which rotates or translates as it does",
       .is_alike = true,
       .fits = has_one_coordinate}};

  double ratio = 1;   // dimensionless
  double offset = 0;  // rad or m

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Coupling::ratio>({.name = "ratio",
                                 .unit = "1",
                                 .text = "change of the coordinate of `joint` by that of `with`",
                                 .range = Range::not_zero,
                                 .required = true}),
        field<&Coupling::offset>(
            {.name = "offset", .unit = "{q}", .text = "coordinate of `joint` when that of `with` is 0"})};
    return all;
  }
  static constexpr SignalGroup outputs[] = {{"{effort}", 0, "{f}", "{torque} of the coupling on joint {joint}"}};

  template <class OnBase>
  double factor(int i, const OnBase&) const {
    return i == 0 ? 1 : -ratio;
  }
  double constant() const { return offset; }
  template <class Seen>
  auto output(const Seen& seen, int, int) const {
    return seen.coordinate_force();
  }
};

}  // namespace gelenk
