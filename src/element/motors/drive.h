// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/gearing.h"
#include "element/joint_forces/coordinate_force.h"

namespace gelenk {

// Applies gear_ratio times its input to a joint coordinate and adds gear_ratio^2 rotor_inertia to its inertia. The
// gyroscopic effect of the rotor on the bodies is neglected.
struct Drive {
  static constexpr std::string_view kind = "drive";
  static constexpr std::string_view summary = "an ideal motor with gear ratio and rotor inertia at a joint";
  static constexpr Port ports[] = {driven_coordinate};

  double gear_ratio = 1;     // motor angle / joint angle (prismatic: motor travel / joint travel)
  double rotor_inertia = 0;  // kg m2 on the motor side (prismatic: kg)

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&Drive::gear_ratio>(gear_ratio_info),
                                    field<&Drive::rotor_inertia>(rotor_inertia_info)};
    return all;
  }

  std::span<const SignalGroup> inputs() const {
    static constexpr SignalGroup all[] = {{"{effort}", 0, "{f}", "{torque} on the motor side, driving joint {joint}"}};
    return all;
  }

  template <class T>
  T effort(const T&, const T&, const T* u) const {
    return T(gear_ratio) * u[0];
  }
  double inertia() const { return reflected_inertia(gear_ratio, rotor_inertia); }
};

}  // namespace gelenk
