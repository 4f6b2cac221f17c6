// SPDX-License-Identifier: BSD-3-Clause
// The rims of a cylinder above a plane.
#pragma once

#include <Eigen/Geometry>

#include "shape/cylinder.h"

namespace gelenk {

// A cylinder with its center and axes in the frame of the computation.
struct CylinderPose {
  CylinderPose(const Cylinder& shape, const Pose3& X)
      : center(X.p), x(X.R.col(0)), y(X.R.col(1)), axis(X.R.col(2)), radius(shape.radius), half(shape.length / 2) {}

  // Center of the cap toward -axis (0) or axis (1).
  Eigen::Vector3d cap(int end) const { return center + (end == 0 ? -half : half) * axis; }
  // Point k of 0..3 of a rim that is fixed to the cylinder: at x, y, -x, -y.
  Eigen::Vector3d rim(int end, int k) const {
    const Eigen::Vector3d& along = k % 2 == 0 ? x : y;
    return cap(end) + (k < 2 ? radius : -radius) * along;
  }

  Eigen::Vector3d center, x, y, axis;
  double radius, half;
};

// Numbers of the features of a cylinder. A rim touches with its point farthest in some direction; a rim point is fixed
// to the cylinder. A crossing is one of two points in which a rim crosses an edge or another rim.
namespace cylinder_feature {
constexpr int rim(int end) { return end; }
constexpr int rim_point(int end, int k) { return 2 + 4 * end + k; }
constexpr int side = 10;
constexpr int cap(int end) { return 11 + end; }
constexpr int crossing(int end, bool second) { return 13 + 2 * end + (second ? 1 : 0); }
constexpr int count = 17;
}  // namespace cylinder_feature

// Below this sine of the angle between the axis and the normal of a surface, a cap is flat on it: the lowest point of
// the rim is not defined, and four fixed points of the rim have gaps that differ from that of the lowest one by less
// than 3e-9 of the radius.
constexpr double flat_cap = 1e-8;
// Up to this sine, points around the rim of the lower cap support the cylinder beside the lowest one; above, the lowest
// points of both rims do.
constexpr double tilted_cap = 0.3;

// Calls visit(point, feature) with the points by which a cylinder can rest on a plane with the normal n.
template <class Visit>
void for_rim_points(const CylinderPose& B, const Eigen::Vector3d& n, const Visit& visit) {
  const double along = n.dot(B.axis);
  // The part of -n across the axis, by its components along x and y: exact for small angles, too.
  const double cx = -n.dot(B.x);
  const double cy = -n.dot(B.y);
  const double sine = std::hypot(cx, cy);
  const int lower = along > 0 ? 0 : 1;
  if (sine > tilted_cap) {
    const Eigen::Vector3d toward = B.radius * (cx / sine * B.x + cy / sine * B.y);
    const int ends = B.half > 0 ? 2 : 1;  // a disk has one rim
    for (int end = 0; end < ends; ++end) visit(Eigen::Vector3d(B.cap(end) + toward), cylinder_feature::rim(end));
    return;
  }
  int replaced = -1;  // the fixed point closest to the lowest one
  if (sine > flat_cap) {
    const Eigen::Vector3d toward = B.radius * (cx / sine * B.x + cy / sine * B.y);
    visit(Eigen::Vector3d(B.cap(lower) + toward), cylinder_feature::rim(lower));
    replaced = std::abs(cx) >= std::abs(cy) ? (cx > 0 ? 0 : 2) : (cy > 0 ? 1 : 3);
  }
  for (int k = 0; k < 4; ++k)
    if (k != replaced) visit(B.rim(lower, k), cylinder_feature::rim_point(lower, k));
}

}  // namespace gelenk
