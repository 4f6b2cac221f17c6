// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "shape/shape.h"

namespace gelenk {

// A box about the origin of S, with edges along the axes of S.
struct Box {
  static constexpr std::string_view kind = "box";
  static constexpr std::string_view summary = "a box with edges along x, y and z";
  static constexpr bool bounded = true;

  Eigen::Vector3d lengths = Eigen::Vector3d::Ones();  // m, of its edges

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&Box::lengths>({.name = "size",
                                                          .unit = "m",
                                                          .text = "lengths of its edges along x, y and z",
                                                          .range = Range::positive,
                                                          .required = true})};
    return all;
  }

  MassProperties mass_properties() const {
    const double V = lengths.prod();
    const Eigen::Vector3d squares = lengths.cwiseAbs2();
    const Eigen::Vector3d moments(squares.y() + squares.z(), squares.z() + squares.x(), squares.x() + squares.y());
    return {V, Eigen::Vector3d::Zero(), (V / 12 * moments).asDiagonal()};
  }
  Eigen::Vector3d support(const Eigen::Vector3d& d) const { return (d.array() < 0).select(-lengths / 2, lengths / 2); }
  double size() const { return lengths.norm(); }
  Aabb bounds(const Pose3& X_WS) const {
    const Eigen::Vector3d reach = X_WS.R.cwiseAbs() * lengths / 2;
    return {X_WS.p - reach, X_WS.p + reach};
  }

  // Corner i of 0..7: bits 0, 1, 2 of i give the sides in x, y, z.
  Eigen::Vector3d corner(int i) const {
    return 0.5 * Eigen::Vector3d((i & 1) != 0 ? lengths.x() : -lengths.x(), (i & 2) != 0 ? lengths.y() : -lengths.y(),
                                 (i & 4) != 0 ? lengths.z() : -lengths.z());
  }
};

}  // namespace gelenk
