// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>

#include "shape/shape.h"

namespace gelenk {

// A ball about the origin of S.
struct Sphere {
  static constexpr std::string_view kind = "sphere";
  static constexpr std::string_view summary = "a sphere";
  static constexpr bool bounded = true;

  double radius = 1;  // m

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&Sphere::radius>(
        {.name = "radius", .unit = "m", .text = "radius", .range = Range::positive, .required = true})};
    return all;
  }

  MassProperties mass_properties() const {
    const double V = 4 * std::numbers::pi / 3 * radius * radius * radius;
    return {V, Eigen::Vector3d::Zero(), 0.4 * V * radius * radius * Eigen::Matrix3d::Identity()};
  }
  Eigen::Vector3d support(const Eigen::Vector3d& d) const {
    const double length = d.norm();
    return length > 0 ? Eigen::Vector3d(radius / length * d) : Eigen::Vector3d(0, 0, radius);
  }
  Drawing drawn(double) const { return {.balls = {{Eigen::Vector3d::Zero(), radius}}}; }
  double size() const { return 2 * radius; }
  Aabb bounds(const Pose3& X_WS) const { return {X_WS.p.array() - radius, X_WS.p.array() + radius}; }
};

}  // namespace gelenk
