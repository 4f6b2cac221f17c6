// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>
#include <optional>

#include "shape/shape.h"
#include "util/text.h"

namespace gelenk {

// All points within the crown radius c of a flat disk of the radius R = radius - c about the z axis of S: a wheel with
// a crowned tire; a thin disk if c = 0, a ball if c = radius.
struct Wheel {
  static constexpr std::string_view kind = "wheel";
  static constexpr std::string_view summary = "a wheel with a crowned tire, about z";
  static constexpr bool bounded = true;

  double radius = 1;  // m
  double crown = 0;   // m

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Wheel::radius>(
            {.name = "radius", .unit = "m", .text = "radius", .range = Range::positive, .required = true}),
        field<&Wheel::crown>({.name = "crown",
                              .unit = "m",
                              .text = "radius of curvature of its tread across, at most its radius",
                              .range = Range::not_negative})};
    return all;
  }

  std::optional<ElementFault> fault() const {
    if (crown <= radius) return {};
    return ElementFault{
        .field = "crown", .found = text::number(crown), .expected = "at most the radius, " + text::number(radius)};
  }

  double disk() const { return radius - crown; }  // m: R

  // A cylinder of length 2 c and, beyond R, the solid of revolution of a half disk with the moments A = pi c^2/2,
  // int x = 2/3 c^3, int x^2 = int z^2 = pi/8 c^4, int x^3 = 4/15 c^5, int x z^2 = 2/15 c^5.
  MassProperties mass_properties() const {
    constexpr double pi = std::numbers::pi;
    const double R = disk();
    const double R2 = R * R;
    const double c2 = crown * crown;
    const double c3 = c2 * crown;
    const double inner = 2 * pi * R2 * crown;
    const double V = inner + pi * pi * R * c2 + 4 * pi / 3 * c3;
    const double along = inner * R2 / 2 + pi * pi * c2 * R * (R2 + 0.75 * c2) + 4 * pi * c3 * (R2 + c2 * 2 / 15);
    const double height = inner * c2 / 3 + pi * c2 * c2 * (pi / 4 * R + crown * 4 / 15);  // int z^2
    return {V, Eigen::Vector3d::Zero(), Eigen::Vector3d(along / 2 + height, along / 2 + height, along).asDiagonal()};
  }
  Eigen::Vector3d support(const Eigen::Vector3d& d) const {
    const double across = std::hypot(d.x(), d.y());
    const double length = d.norm();
    Eigen::Vector3d out = across > 0 ? Eigen::Vector3d(disk() / across * d.x(), disk() / across * d.y(), 0)
                                     : Eigen::Vector3d(disk(), 0, 0);
    if (length > 0) out += crown / length * d;
    return out;
  }
  // A thin disk gets some thickness.
  Drawing drawn(double) const {
    const Eigen::Vector3d end(0, 0, 0.02 * radius);
    return crown < end.z() ? Drawing{.tubes = {{-end, end, radius}}} : Drawing{};
  }
  double size() const { return 2 * radius; }
  Aabb bounds(const Pose3& X_WS) const {
    const Eigen::Vector3d a = X_WS.R.col(2);
    const Eigen::Vector3d reach =
        disk() * Eigen::Vector3d(std::hypot(a.y(), a.z()), std::hypot(a.z(), a.x()), std::hypot(a.x(), a.y())).array() +
        crown;
    return {X_WS.p - reach, X_WS.p + reach};
  }
};

}  // namespace gelenk
