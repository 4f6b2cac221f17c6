// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>

#include "shape/shape.h"

namespace gelenk {

// All points within a distance, the radius, of a segment about the origin of S along its z axis.
struct Capsule {
  static constexpr std::string_view kind = "capsule";
  static constexpr std::string_view summary = "a cylinder with hemispheres at both ends, along z";
  static constexpr bool bounded = true;

  double radius = 1;  // m
  double length = 1;  // m, between the centers of the hemispheres

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Capsule::radius>(
            {.name = "radius", .unit = "m", .text = "radius", .range = Range::positive, .required = true}),
        field<&Capsule::length>({.name = "length",
                                 .unit = "m",
                                 .text = "distance between the centers of its ends",
                                 .range = Range::positive,
                                 .required = true})};
    return all;
  }

  MassProperties mass_properties() const {
    const double r2 = radius * radius;
    const double L = length;
    const double tube = std::numbers::pi * r2 * L;
    const double ball = 4 * std::numbers::pi / 3 * r2 * radius;
    const double along = tube * r2 / 2 + ball * 0.4 * r2;
    const double across = tube * (r2 / 4 + L * L / 12) + ball * (0.4 * r2 + L * L / 4 + 0.375 * L * radius);
    return {tube + ball, Eigen::Vector3d::Zero(), Eigen::Vector3d(across, across, along).asDiagonal()};
  }
  Eigen::Vector3d support(const Eigen::Vector3d& d) const {
    const double n = d.norm();
    const Eigen::Vector3d end(0, 0, d.z() < 0 ? -length / 2 : length / 2);
    return n > 0 ? Eigen::Vector3d(end + radius / n * d) : Eigen::Vector3d(0, 0, length / 2 + radius);
  }
  Drawing drawn(double) const {
    const Eigen::Vector3d end(0, 0, length / 2);
    return {.balls = {{-end, radius}, {end, radius}}, .tubes = {{-end, end, radius}}};
  }
  double size() const { return length + 2 * radius; }
  Aabb bounds(const Pose3& X_WS) const {
    const Eigen::Vector3d reach = (length / 2 * X_WS.R.col(2)).cwiseAbs().array() + radius;
    return {X_WS.p - reach, X_WS.p + reach};
  }
};

}  // namespace gelenk
