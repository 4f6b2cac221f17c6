// SPDX-License-Identifier: BSD-3-Clause
// Shapes as all points within a radius of a box or of single points, for contacts whose gap is a smooth function of the
// poses: of the tips of one shape with the core of another.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "shape/kinds.h"

namespace gelenk {

// All points within a radius of the box |x_k| <= half_k in S; a box of no size is a ball, one with one edge a capsule.
struct RoundedBox {
  Eigen::Vector3d half = Eigen::Vector3d::Zero();  // m
  double radius = 0;                               // m
  bool half_space = false;                         // instead: the points with z <= 0

  bool is_ball() const { return !half_space && half.isZero(0); }
};

// A ball that is part of a convex solid. A plane touches the solid where it touches one of the tips. S: its frame.
struct Tip {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  // m
  double radius = 0;                                 // m
  int feature = 0;                                   // as in collision/contacts.h
};

// The shape as a rounded box, and its tips; none for shapes that have none.
std::optional<RoundedBox> core_of(const AnyShape& shape);
std::vector<Tip> tips_of(const AnyShape& shape);
// Whether all contacts of the two shapes are those of the tips of the first with the core of the second.
bool tips_touch_core(const AnyShape& of_tips, const AnyShape& of_core);

}  // namespace gelenk
