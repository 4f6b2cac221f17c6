// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "shape/shape.h"

namespace gelenk {

// A half-space: the points of S with z <= 0. The z axis of S is the normal of its surface and points out of the solid.
struct Plane {
  static constexpr std::string_view kind = "plane";
  static constexpr std::string_view summary = "a half-space below its surface; z is the normal of the surface";
  static constexpr bool bounded = false;

  static std::span<const Field> fields() { return {}; }

  // A square slab below the surface.
  static Drawing drawn(double extent) {
    Drawing out;
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) {
        for (const double z : {-0.01, 0.0}) out.points.emplace_back(extent * Eigen::Vector3d(x, y, z));
      }
    }
    return out;
  }

  // Bounded only by its surface, if that is normal to an axis of W.
  static Aabb bounds(const Pose3& X_WS) {
    Aabb out;
    const Eigen::Vector3d n = X_WS.R.col(2);
    for (Eigen::Index i = 0; i < 3; ++i) {
      if (n((i + 1) % 3) != 0 || n((i + 2) % 3) != 0) continue;
      (n(i) > 0 ? out.upper : out.lower)(i) = X_WS.p(i);
    }
    return out;
  }
};

}  // namespace gelenk
