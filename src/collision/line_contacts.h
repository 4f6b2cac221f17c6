// SPDX-License-Identifier: BSD-3-Clause
// Contact points of straight lines with a radius (capsules, edges, sides of cylinders) and of the rims of cylinders.
#pragma once

#include <Eigen/Geometry>

#include "collision/contact_set.h"
#include "collision/cylinder.h"
#include "collision/solid.h"

namespace gelenk {

// Closest points of two bodies from which the routines of this header start.
struct ClosestNormal {
  Eigen::Vector3d n = Eigen::Vector3d::UnitZ();  // unit vector from A to B
  double least = 0;  // m: pairs of features with a smaller gap belong to other directions of contact

  ClosestNormal reversed() const { return {-n, least}; }
};

// Adds points with the bodies exchanged or not: normals given to add() point from the first to the second of two
// bodies.
class PointSink {
 public:
  // count: number of features of body B.
  PointSink(ContactSet& out, bool exchanged, int count_B) : out_(out), exchanged_(exchanged), count_B_(count_B) {}

  // The same for the bodies in the opposite order.
  PointSink exchanged() const { return {out_, !exchanged_, count_B_}; }
  // on_first: a point of the first body or of the second one, at the gap from the other body along n.
  void add(const Eigen::Vector3d& x, bool on_first, const Eigen::Vector3d& n, double gap, int first, int second) const;

 private:
  ContactSet& out_;
  bool exchanged_;
  int count_B_;
};

// A segment with a radius; features of its ends and of the part between.
struct Line {
  Eigen::Vector3d center, along;
  double half = 0, radius = 0;
  int ends[2] = {0, 1};
  int middle = 2;

  Eigen::Vector3d end(int i) const { return center + (i == 0 ? -half : half) * along; }
  double coordinate(const Eigen::Vector3d& x) const { return along.dot(x - center); }
  // Whether a coordinate is between the ends; slack: a fraction of the length.
  bool has(double x, double slack) const { return std::abs(x) <= half * (1 + slack); }
};

// Parts of lengths that rounding errors must not decide about.
constexpr double line_slack = 1e-6;

// Ends of a line (first body) above the face of a solid (second body) and crossings with its edges.
void line_on_solid(const Line& line, const Solid& solid, const ClosestNormal& at, const PointSink& out);
// The end of a line (first body) above a flat cap (second body).
void line_ends_on_cap(const Line& line, const CylinderPose& cylinder, const ClosestNormal& at, const PointSink& out);
// Two lines side by side: ends of the first above the second.
void line_ends_on_line(const Line& line, const Line& other, const ClosestNormal& at, double slack,
                       const PointSink& out);
// The place where two lines cross.
void line_across_line(const Line& line, const Line& other, const ClosestNormal& at, const PointSink& out);
// The places where the rim of a cylinder (first body) crosses a line (second body).
void rim_across_line(const CylinderPose& cylinder, int end, const Line& line, const ClosestNormal& at,
                     const PointSink& out);
// The rim of a cylinder (first body) above a line (second body) to which its axis is nearly parallel.
void rim_on_line(const CylinderPose& cylinder, int end, const Line& line, const ClosestNormal& at, double slack,
                 const PointSink& out);
// The places where two rims cross.
void rim_across_rim(const CylinderPose& A, int end_A, const CylinderPose& B, int end_B, const ClosestNormal& at,
                    const PointSink& out);

// A cylinder (first body) at a solid (second body), and two cylinders.
void cylinder_on_solid(const CylinderPose& cylinder, const Solid& solid, const ClosestNormal& at, const PointSink& out);
void cylinder_on_cylinder(const CylinderPose& A, const CylinderPose& B, const ClosestNormal& at, const PointSink& out);
void line_on_cylinder(const Line& line, const CylinderPose& cylinder, const ClosestNormal& at, const PointSink& out);

// An edge of a face of a solid as a line.
Line edge_line(const Solid& solid, int face, std::size_t place);
// The side of a cylinder as a line.
Line side_line(const CylinderPose& cylinder);

}  // namespace gelenk
