// SPDX-License-Identifier: BSD-3-Clause
// Cylinders on caps, rims and sides.
#include "collision/face_contacts.h"
#include "collision/line_contacts.h"

namespace gelenk {
namespace {

// A cylinder lies on its side up to this sine of the angle between its axis and the surface: 10 degrees, as `facing`.
constexpr double lying = 0.172;

// A cap as a flat disk with its outer normal.
struct Cap {
  // The cap toward d.
  Cap(const CylinderPose& of, const Eigen::Vector3d& d)
      : end(d.dot(of.axis) < 0 ? 0 : 1),
        center(of.cap(end)),
        normal(end == 0 ? Eigen::Vector3d(-of.axis) : of.axis),
        radius(of.radius),
        is_facing(normal.dot(d) > facing) {}

  double height(const Eigen::Vector3d& x) const { return normal.dot(x - center); }
  bool covers(const Eigen::Vector3d& x, double slack) const {
    return normal.cross(x - center).norm() <= radius * (1 + slack);
  }

  int end;
  Eigen::Vector3d center, normal;
  double radius;
  bool is_facing;
};

// Rim points of the first cylinder above the cap of the second one; slack: relative to the radius.
void rim_points_on_cap(const CylinderPose& first, const Cap& cap, const ClosestNormal& at, double slack,
                       const PointSink& out) {
  if (!cap.is_facing) return;
  for_rim_points(first, cap.normal, [&](const Eigen::Vector3d& x, int feature) {
    const double gap = cap.height(x);
    if (gap < at.least || !cap.covers(x, slack)) return;
    out.add(x, true, -cap.normal, gap, feature, cylinder_feature::cap(cap.end));
  });
}

}  // namespace

void cylinder_on_solid(const CylinderPose& cylinder, const Solid& solid, const ClosestNormal& at,
                       const PointSink& out) {
  const int face = solid.face_toward(-at.n);
  const Eigen::Vector3d normal = solid.normal(face);
  const double slack = line_slack * std::min(solid.size(), cylinder.radius);
  if (-normal.dot(at.n) > facing) {
    for_rim_points(cylinder, normal, [&](const Eigen::Vector3d& x, int feature) {
      const double gap = solid.height(face, normal, x);
      if (gap < at.least || !solid.covers(face, normal, x, slack)) return;
      out.add(x, true, -normal, gap, feature, solid.face_feature(face));
    });
  }
  const Cap cap(cylinder, at.n);
  if (cap.is_facing) {
    for (const int v : solid.loop(face)) {
      const Eigen::Vector3d x = solid.vertex(v);
      const double gap = cap.height(x);
      if (gap >= at.least && cap.covers(x, line_slack))
        out.add(x, false, cap.normal, gap, cylinder_feature::cap(cap.end), v);
    }
  }
  const bool lies = std::abs(at.n.dot(cylinder.axis)) < lying;
  if (!cap.is_facing && !lies) return;
  for (std::size_t i = 0; i < solid.loop(face).size(); ++i) {
    const Line edge = edge_line(solid, face, i);
    if (cap.is_facing) rim_across_line(cylinder, cap.end, edge, at, out);
    if (lies) line_across_line(side_line(cylinder), edge, at, out);
  }
}

void cylinder_on_cylinder(const CylinderPose& A, const CylinderPose& B, const ClosestNormal& at, const PointSink& out) {
  const PointSink exchanged = out.exchanged();
  const ClosestNormal back = at.reversed();
  const Cap cap_A(A, at.n);
  const Cap cap_B(B, back.n);
  const bool A_lies = std::abs(at.n.dot(A.axis)) < lying;
  const bool B_lies = std::abs(at.n.dot(B.axis)) < lying;
  if (cap_A.is_facing || cap_B.is_facing) {
    rim_points_on_cap(B, cap_A, back, line_slack, exchanged);
    // Rims on each other count once.
    rim_points_on_cap(A, cap_B, at, -line_slack, out);
    if (cap_A.is_facing && cap_B.is_facing) rim_across_rim(A, cap_A.end, B, cap_B.end, at, out);
    if (cap_A.is_facing && B_lies) rim_across_line(A, cap_A.end, side_line(B), at, out);
    if (cap_B.is_facing && A_lies) rim_across_line(B, cap_B.end, side_line(A), back, exchanged);
  } else if (A_lies && B_lies) {
    for (int end = 0; end < 2; ++end) rim_on_line(A, end, side_line(B), at, line_slack, out);
    for (int end = 0; end < 2; ++end) rim_on_line(B, end, side_line(A), back, -line_slack, exchanged);
  }
}

void line_on_cylinder(const Line& line, const CylinderPose& cylinder, const ClosestNormal& at, const PointSink& out) {
  const PointSink exchanged = out.exchanged();
  const ClosestNormal back = at.reversed();
  const Cap cap(cylinder, back.n);
  if (cap.is_facing) {
    line_ends_on_cap(line, cylinder, at, out);
    if (std::abs(line.along.dot(at.n)) < lying) rim_across_line(cylinder, cap.end, line, back, exchanged);
  } else if (std::abs(at.n.dot(cylinder.axis)) < lying) {
    const Line side = side_line(cylinder);
    line_ends_on_line(line, side, at, line_slack, out);
    for (int end = 0; end < 2; ++end) rim_on_line(cylinder, end, line, back, -line_slack, exchanged);
  }
}

}  // namespace gelenk
