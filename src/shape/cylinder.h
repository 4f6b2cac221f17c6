// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>

#include "shape/shape.h"

namespace gelenk {

// A circular cylinder about the origin of S, along its z axis.
struct Cylinder {
  static constexpr std::string_view kind = "cylinder";
  static constexpr std::string_view summary = "a cylinder along z";
  static constexpr bool bounded = true;

  double radius = 1;  // m
  double length = 1;  // m

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Cylinder::radius>(
            {.name = "radius", .unit = "m", .text = "radius", .range = Range::positive, .required = true}),
        field<&Cylinder::length>(
            {.name = "length", .unit = "m", .text = "length", .range = Range::positive, .required = true})};
    return all;
  }

  MassProperties mass_properties() const {
    const double r2 = radius * radius;
    const double V = std::numbers::pi * r2 * length;
    const double across = V * (r2 / 4 + length * length / 12);
    return {V, Eigen::Vector3d::Zero(), Eigen::Vector3d(across, across, V * r2 / 2).asDiagonal()};
  }
  Eigen::Vector3d support(const Eigen::Vector3d& d) const {
    const double across = std::hypot(d.x(), d.y());
    const double z = d.z() < 0 ? -length / 2 : length / 2;
    return across > 0 ? Eigen::Vector3d(radius * (d.x() / across), radius * (d.y() / across), z)
                      : Eigen::Vector3d(radius, 0, z);
  }
  Drawing drawn(double) const {
    const Eigen::Vector3d end(0, 0, length / 2);
    return {.tubes = {{-end, end, radius}}};
  }
  double size() const { return std::hypot(2 * radius, length); }
  Aabb bounds(const Pose3& X_WS) const {
    // A disk with the axis a reaches r sqrt(1 - a_i^2) along axis i, which is the length of the other two components of
    // a.
    const Eigen::Vector3d a = X_WS.R.col(2);
    const Eigen::Vector3d disk(std::hypot(a.y(), a.z()), std::hypot(a.z(), a.x()), std::hypot(a.x(), a.y()));
    const Eigen::Vector3d reach = length / 2 * a.cwiseAbs() + radius * disk;
    return {X_WS.p - reach, X_WS.p + reach};
  }
};

}  // namespace gelenk
