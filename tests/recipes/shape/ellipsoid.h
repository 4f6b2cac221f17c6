// SPDX-License-Identifier: BSD-3-Clause
// Example of a shape; tests/test_recipes.py adds it.
#pragma once

#include <numbers>

#include "shape/shape.h"

namespace gelenk {

// The points with (x/a)^2 + (y/b)^2 + (z/c)^2 <= 1, where a, b, c are the half axes.
struct Ellipsoid {
  static constexpr std::string_view kind = "ellipsoid";
  static constexpr std::string_view summary = "an ellipsoid with axes along x, y and z";
  static constexpr bool bounded = true;

  Eigen::Vector3d half_axes = Eigen::Vector3d::Ones();  // m

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&Ellipsoid::half_axes>({.name = "half_axes",
                                                                  .unit = "m",
                                                                  .text = "half axes along x, y and z",
                                                                  .range = Range::positive,
                                                                  .required = true})};
    return all;
  }

  MassProperties mass_properties() const {
    const double V = 4 * std::numbers::pi / 3 * half_axes.prod();
    const Eigen::Vector3d squares = half_axes.cwiseAbs2();
    const Eigen::Vector3d moments = V / 5 * (Eigen::Vector3d::Constant(squares.sum()) - squares);
    return {V, Eigen::Vector3d::Zero(), moments.asDiagonal()};
  }
  Eigen::Vector3d support(const Eigen::Vector3d& d) const {
    const Eigen::Vector3d stretched = half_axes.cwiseProduct(d);
    const double length = stretched.norm();
    return length > 0 ? Eigen::Vector3d(half_axes.cwiseProduct(stretched) / length)
                      : Eigen::Vector3d(half_axes.x(), 0, 0);
  }
  double size() const { return 2 * half_axes.maxCoeff(); }
  Aabb bounds(const Pose3& X_WS) const {
    const Eigen::Vector3d reach = (X_WS.R * half_axes.asDiagonal()).rowwise().norm();
    return {X_WS.p - reach, X_WS.p + reach};
  }
};

}  // namespace gelenk
