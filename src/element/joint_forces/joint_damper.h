// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "element/joint_forces/coordinate_force.h"

namespace gelenk {

// Viscous damper on a joint coordinate: tau = -damping v.
struct JointDamper {
  static constexpr std::string_view group{};
  static constexpr std::string_view summary = "a viscous damper on the coordinate";
  static constexpr std::string_view misfit = "cannot move";  // of a joint with coordinates
  static bool fits(const JointKind& kind) { return kind.nv > 0; }

  double damping = 0;  // N m s/rad (N s/m)

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&JointDamper::damping>({.name = "damping",
                                                                  .unit = "{f}.s/{q}",
                                                                  .text = "damping on {speed}",
                                                                  .range = Range::not_negative,
                                                                  .tunable = true})};
    return all;
  }

  bool is_idle() const { return damping == 0; }
  template <class T>
  T effort(const T&, const T& v, const T*) const {
    return -(T(damping) * v);
  }
  std::array<double, 2> jacobians(double, double) const { return {0, -damping}; }
};

}  // namespace gelenk
