// SPDX-License-Identifier: BSD-3-Clause
// What a shape looks like from far away, for the drawing of a scene.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "shape/kinds.h"

namespace gelenk {

// What covers a shape as seen from right x up: sets of points in the world frame, whose convex hulls in the picture do,
// and the lines around them; without lines, around each hull. Both vectors are units in the world frame. Of a
// half-space nothing.
struct Outline {
  std::vector<std::vector<Eigen::Vector3d>> faces;
  std::vector<std::array<Eigen::Vector3d, 2>> lines;
};
Outline outline_of(const AnyShape& shape, const Pose3& X_WS, const Eigen::Vector3d& right, const Eigen::Vector3d& up);

}  // namespace gelenk
