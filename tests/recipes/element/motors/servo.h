// SPDX-License-Identifier: BSD-3-Clause
// Example of a motor; tests/test_recipes.py adds it.
#pragma once

#include "element/joint_forces/coordinate_force.h"

namespace gelenk {

// tau = gain (u - q).
struct Servo {
  static constexpr std::string_view kind = "servo";
  static constexpr std::string_view summary = "proportional position control of a joint";
  static constexpr Port ports[] = {{.kind = Port::Kind::joint,
                                    .name = "joint",
                                    .text = "Joint with one degree of freedom",
                                    .fits = [](const JointKind& kind) { return kind.nq == 1 && kind.nv == 1; }}};

  double gain = 0;  // N m/rad (N/m)

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&Servo::gain>({.name = "gain",
                                                         .unit = "{f}/{q}",
                                                         .text = "proportional gain at joint {joint}",
                                                         .range = Range::positive,
                                                         .required = true})};
    return all;
  }

  std::span<const SignalGroup> inputs() const {
    static constexpr SignalGroup all[] = {{"{coordinate}_wanted", 0, "{q}", "target position of joint {joint}",
                                           Stage::acceleration, SignalGroup::Start::coordinate}};
    return all;
  }

  template <class T>
  T effort(const T& q, const T&, const T* u) const {
    return T(gain) * (u[0] - q);
  }
};

}  // namespace gelenk
