// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "element/joint_forces/coordinate_force.h"

namespace gelenk {

// Linear spring on a joint coordinate: tau = -stiffness (q - spring_reference).
struct JointSpring {
  static constexpr std::string_view group{};
  static constexpr std::string_view summary = "a linear spring on the coordinate";
  static constexpr std::string_view misfit = "has no angles that a spring could act on";  // of a joint with coordinates
  static bool fits(const JointKind& kind) { return kind.springs(); }

  double stiffness = 0;         // N m/rad (N/m)
  double spring_reference = 0;  // rad (m)

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&JointSpring::stiffness>({.name = "stiffness",
                                        .unit = "{f}/{q}",
                                        .text = "stiffness on {coordinate}",
                                        .range = Range::not_negative,
                                        .tunable = true}),
        field<&JointSpring::spring_reference>({.name = "spring_reference",
                                               .unit = "{q}",
                                               .text = "unloaded position of the spring, {coordinate}",
                                               .tunable = true})};
    return all;
  }

  bool is_idle() const { return stiffness == 0; }
  template <class T>
  T effort(const T& q, const T&, const T*) const {
    return -(T(stiffness) * (q - T(spring_reference)));
  }
  std::array<double, 2> jacobians(double, double) const { return {-stiffness, 0}; }
  template <class T>
  T energy(const T& q) const {
    return T(stiffness / 2) * (q - T(spring_reference)) * (q - T(spring_reference));
  }
};

}  // namespace gelenk
