// SPDX-License-Identifier: BSD-3-Clause
#include "collision/cylinder.h"
#include "collision/pairs.h"

namespace gelenk {
namespace {

struct Surface {
  Eigen::Vector3d n, p;
  explicit Surface(const Pose3& X_P) : n(X_P.R.col(2)), p(X_P.p) {}
  double height(const Eigen::Vector3d& x) const { return n.dot(x - p); }
};

}  // namespace

void plane_contacts(const Pose3& X_P, const Sphere& B, const Pose3& X_B, ContactSet& out) {
  const Surface plane(X_P);
  const double gap = plane.height(X_B.p) - B.radius;
  out.add_above(X_B.p - B.radius * plane.n, plane.n, gap, 0);
}

// Features are the ends of the capsule, the one toward -z first.
void plane_contacts(const Pose3& X_P, const Capsule& B, const Pose3& X_B, ContactSet& out) {
  const Surface plane(X_P);
  for (int end = 0; end < 2; ++end) {
    const Eigen::Vector3d center = X_B.p + (end == 0 ? -0.5 : 0.5) * B.length * X_B.R.col(2);
    out.add_above(center - B.radius * plane.n, plane.n, plane.height(center) - B.radius, end);
  }
}

// Features are the corners.
void plane_contacts(const Pose3& X_P, const Box& B, const Pose3& X_B, ContactSet& out) {
  const Surface plane(X_P);
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner = X_B.point(B.corner(i));
    out.add_above(corner, plane.n, plane.height(corner), i);
  }
}

void plane_contacts(const Pose3& X_P, const Cylinder& B, const Pose3& X_B, ContactSet& out) {
  const Surface plane(X_P);
  for_rim_points(CylinderPose(B, X_B), plane.n,
                 [&](const Eigen::Vector3d& x, int feature) { out.add_above(x, plane.n, plane.height(x), feature); });
}

// As the rims of the disk within the crown.
void plane_contacts(const Pose3& X_P, const Wheel& B, const Pose3& X_B, ContactSet& out) {
  const Surface plane(X_P);
  const auto add = [&](const Eigen::Vector3d& x, int feature) {
    out.add_above(x - B.crown * plane.n, plane.n, plane.height(x) - B.crown, feature);
  };
  if (B.disk() > 0) {
    for_rim_points(CylinderPose(Cylinder{B.disk(), 0}, X_B), plane.n, add);
  } else {
    add(X_B.p, 0);
  }
}

// Features are the vertices.
void plane_contacts(const Pose3& X_P, const Hull& B, const Pose3& X_B, ContactSet& out) {
  const Surface plane(X_P);
  // In the frame of the hull: cheaper for many vertices.
  const Eigen::Vector3d n = X_B.R.transpose() * plane.n;
  const double offset = plane.height(X_B.p);
  const std::vector<Eigen::Vector3d>& vertices = B.polyhedron().vertices;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const double gap = n.dot(vertices[i]) + offset;
    if (gap <= out.margin()) out.add_above(X_B.point(vertices[i]), plane.n, gap, static_cast<int>(i));
  }
}

}  // namespace gelenk
