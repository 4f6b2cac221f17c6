// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>

namespace gelenk {

// The point of the hull of 1 to 4 points that is closest to the origin.
struct SimplexPoint {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  std::array<double, 4> weights{};  // barycentric coordinates; 0 of points that are not needed
};

SimplexPoint closest_to_origin(const std::array<Eigen::Vector3d, 4>& points, int count);

}  // namespace gelenk
