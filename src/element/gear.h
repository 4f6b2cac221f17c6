// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/constraint.h"

namespace gelenk {

// phi_joint - phi_carrier = ratio (phi_with - phi_carrier) + offset, phi_carrier left out where there is no carrier,
// and where a joint hangs on the carrier itself: its angle is against it already.
struct Gear {
  static constexpr std::string_view kind = "gear";
  static constexpr std::string_view summary = "two joints turn at a fixed ratio, against a carrier if there is one";
  static constexpr auto turns = [](const JointKind& kind) {
    return kind.nq == 1 && kind.nv == 1 && kind.q[0].unit == "rad";
  };
  static constexpr Port ports[] = {
      {.kind = Port::Kind::joint, .name = "joint", .text = "Joint that turns", .fits = turns},
      {.kind = Port::Kind::joint, .name = "with", .text = "Another", .fits = turns},
      {.kind = Port::Kind::joint,
       .name = "carrier",
       .text = "A third, against which both turn; none if not given",
       .optional = true,
       .fits = turns}};

  double ratio = 1;   // -
  double offset = 0;  // rad

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Gear::ratio>({.name = "ratio",
                             .unit = "1",
                             .text = "turns of the first joint for a turn of the other",
                             .range = Range::not_zero,
                             .required = true}),
        field<&Gear::offset>(
            {.name = "offset", .unit = "rad", .text = "angle of the first joint where the other is at 0"})};
    return all;
  }
  static constexpr SignalGroup outputs[] = {{"tau", 0, "N.m", "torque of the gear on joint {joint}"}};

  template <class OnBase>
  double factor(int i, const OnBase& on_base) const {
    if (i == 0) return 1;
    if (i == 1) return -ratio;
    return (on_base(1) ? ratio : 0) - (on_base(0) ? 1 : 0);
  }
  double constant() const { return offset; }
  template <class Seen>
  auto output(const Seen& seen, int, int) const {
    return seen.coordinate_force();
  }
};

}  // namespace gelenk
