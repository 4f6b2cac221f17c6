// SPDX-License-Identifier: BSD-3-Clause
// Springs between two points that have come together.
#pragma once

#include "dynamics/dynamics.h"

namespace gelenk {

// The force of the scene, a spring or damper between two points, whose ends meet: its direction is not defined there.
// -1: there is none. at: after set_root_poses().
inline int collapsed_spring(const Loads& loads, const Dynamics& at) {
  constexpr double meet = 1e-9;  // m: nearer, rounding of 1e-15 leaves its direction less than six digits
  for (const PointSpring& spring : loads.springs) {
    if (spring.is_linear() || (spring.stiffness == 0 && spring.damping == 0)) continue;
    const Eigen::Vector3d from = at.link_pose(spring.from.link).point(spring.from.p);
    const Eigen::Vector3d to = at.link_pose(spring.to.link).point(spring.to.p);
    if ((to - from).norm() <= meet) return spring.force;
  }
  return -1;
}

}  // namespace gelenk
