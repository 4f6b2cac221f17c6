// SPDX-License-Identifier: BSD-3-Clause
// Signed distance of two convex bodies by their support functions.
#pragma once

#include <array>
#include <optional>
#include <variant>

#include "collision/cylinder.h"
#include "collision/solid.h"
#include "shape/registry.h"

namespace gelenk {

// A point of a body that is farthest in some direction; vertex: its number, -1 on curved surfaces.
struct Support {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  int vertex = -1;
};

// A bounded shape at a pose as a core and a radius, the points within this distance of the core. The core of a sphere
// is a point, that of a capsule a segment; other shapes are their own core.
class ConvexBody {
 public:
  ConvexBody(const AnyShape& shape, const Pose3& X);

  double radius() const { return radius_; }  // m
  double size() const { return size_; }      // m, of the core
  const Eigen::Vector3d& center() const { return center_; }
  Support support(const Eigen::Vector3d& d) const;

  const Solid* solid() const { return std::get_if<Solid>(&core_); }
  const CylinderPose* cylinder() const { return std::get_if<CylinderPose>(&core_); }
  // Unit vector along a segment, and its half length; none for other cores.
  struct Axis {
    Eigen::Vector3d along;
    double half;
  };
  const Axis* segment() const { return std::get_if<Axis>(&core_); }

  // Numbers of features of the core: as in class Solid; ends 0, 1 and middle 2 of a segment; 0 of a point; of a
  // cylinder as in cylinder.h.
  int feature_count() const;

 private:
  struct Point {};
  std::variant<Point, Axis, Solid, CylinderPose> core_;
  Eigen::Vector3d center_;
  double radius_ = 0;
  double size_ = 0;
};

// A point b - a of the difference of the cores of two bodies.
struct Difference {
  Eigen::Vector3d w = Eigen::Vector3d::Zero();
  Support a, b;
};

// The closest points of two cores or, if they overlap, the points that the shortest translation brings into contact.
struct ClosestPoints {
  Eigen::Vector3d n = Eigen::Vector3d::UnitZ();  // unit vector from A to B
  double distance = 0;                           // m, of the cores, along n; negative: overlap
  Eigen::Vector3d a = Eigen::Vector3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  std::array<Difference, 3> by;  // a and b are means of these with the weights
  std::array<double, 3> weights{};
  int count = 0;
};

// Separation of the cores along the unit vector n from A to B: a lower bound of their signed distance, which is the
// largest separation along any direction.
double separation(const ConvexBody& A, const ConvexBody& B, const Eigen::Vector3d& n);
// Points of both cores farthest toward each other along n.
Difference difference(const ConvexBody& A, const ConvexBody& B, const Eigen::Vector3d& n);

// Finds the closest points of two cores; none if their distance exceeds the limit.
std::optional<ClosestPoints> closest_points(const ConvexBody& A, const ConvexBody& B, double limit);

// Depth of overlap from points whose hull contains the origin or is within rounding errors of it; penetration.cpp.
ClosestPoints penetration(const ConvexBody& A, const ConvexBody& B, const std::array<Difference, 4>& start, int count);

// Replaces the normal by that of the features that touch, exact to within rounding errors; refine.cpp.
void refine(const ConvexBody& A, const ConvexBody& B, ClosestPoints& found);

}  // namespace gelenk
