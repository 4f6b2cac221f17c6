// SPDX-License-Identifier: BSD-3-Clause
// Contact points of convex bodies: their closest points, and further ones around them.
#include <Eigen/Geometry>
#include <algorithm>

#include "collision/convex.h"
#include "collision/face_contacts.h"
#include "collision/line_contacts.h"
#include "collision/pairs.h"

namespace gelenk {
namespace {

// Weights below this are rounding errors of an iteration: the point is not needed.
constexpr double no_weight = 1e-9;

int feature_of_solid(const Solid& solid, const ClosestPoints& found, Support Difference::* of,
                     const Eigen::Vector3d& n) {
  std::array<int, 3> vertices{};
  int count = 0;
  for (int i = 0; i < found.count; ++i) {
    const int v = (found.by[static_cast<std::size_t>(i)].*of).vertex;
    const bool known = std::find(vertices.begin(), vertices.begin() + count, v) != vertices.begin() + count;
    if (found.weights[static_cast<std::size_t>(i)] > no_weight && !known)
      vertices[static_cast<std::size_t>(count++)] = v;
  }
  if (count == 1) return vertices[0];
  if (count == 2) {
    const int edge = solid.edge_between(vertices[0], vertices[1]);
    if (edge >= 0) return solid.edge_feature(edge);
  }
  return solid.face_feature(solid.face_toward(n));
}

int feature_of_cylinder(const CylinderPose& cylinder, const Eigen::Vector3d& n) {
  const double along = n.dot(cylinder.axis);
  const int end = along < 0 ? 0 : 1;
  if (n.cross(cylinder.axis).norm() <= flat_cap) return cylinder_feature::cap(end);
  return std::abs(along) <= flat_cap ? cylinder_feature::side : cylinder_feature::rim(end);
}

// Feature of a body at the closest points; n: outward.
int feature_of(const ConvexBody& body, const ClosestPoints& found, Support Difference::* of, const Eigen::Vector3d& n) {
  if (const Solid* solid = body.solid()) return feature_of_solid(*solid, found, of, n);
  if (const CylinderPose* cylinder = body.cylinder()) return feature_of_cylinder(*cylinder, n);
  if (body.segment() == nullptr) return 0;
  double to_end = 0;
  for (int i = 0; i < found.count; ++i)
    if ((found.by[static_cast<std::size_t>(i)].*of).vertex == 1) to_end += found.weights[static_cast<std::size_t>(i)];
  return to_end <= no_weight ? 0 : to_end >= 1 - no_weight ? 1 : 2;
}

Line line_of(const ConvexBody& body) {
  const ConvexBody::Axis& segment = *body.segment();
  return {.center = body.center(), .along = segment.along, .half = segment.half, .radius = body.radius()};
}

// Contact points around the closest ones.
void further_contacts(const ConvexBody& a, const ConvexBody& b, const Eigen::Vector3d& n, double distance,
                      ContactSet& out) {
  // The core of a wheel has no thickness: its closest points are all.
  const auto is_disk = [](const ConvexBody& body) { return body.cylinder() != nullptr && body.cylinder()->half == 0; };
  if (is_disk(a) || is_disk(b)) return;
  const double size = std::min(a.size(), b.size());
  const ClosestNormal at{n, distance - a.radius() - b.radius() - same_contact * size};
  const PointSink in_order(out, false, b.feature_count());
  const PointSink exchanged = in_order.exchanged();
  if (a.solid() != nullptr) {
    if (b.solid() != nullptr) face_contacts(*a.solid(), *b.solid(), n, distance, out);
    if (b.cylinder() != nullptr) cylinder_on_solid(*b.cylinder(), *a.solid(), at.reversed(), exchanged);
  } else if (a.cylinder() != nullptr) {
    if (b.solid() != nullptr) cylinder_on_solid(*a.cylinder(), *b.solid(), at, in_order);
    if (b.cylinder() != nullptr) cylinder_on_cylinder(*a.cylinder(), *b.cylinder(), at, in_order);
  } else if (a.segment() != nullptr) {
    if (b.solid() != nullptr) line_on_solid(line_of(a), *b.solid(), at, in_order);
    if (b.cylinder() != nullptr) line_on_cylinder(line_of(a), *b.cylinder(), at, in_order);
  }
}

}  // namespace

void convex_contacts(const AnyShape& A, const Pose3& X_A, const AnyShape& B, const Pose3& X_B, ContactSet& out) {
  const ConvexBody a(A, X_A);
  const ConvexBody b(B, X_B);
  const double radii = a.radius() + b.radius();
  const std::optional<ClosestPoints> found = closest_points(a, b, out.margin() + radii);
  if (!found) return;
  const Eigen::Vector3d& n = found->n;
  further_contacts(a, b, n, found->distance, out);
  const double gap = found->distance - radii;
  if (out.least_gap() <= gap + 1e-12 * (a.size() + b.size())) return;
  const int feature = pair_feature(feature_of(a, *found, &Difference::a, n), feature_of(b, *found, &Difference::b, -n),
                                   b.feature_count());
  // Where a curved surface is replaced by a facet, the points are not quite above each other.
  const Eigen::Vector3d middle = (found->a + a.radius() * n + found->b - b.radius() * n) / 2;
  out.add({middle, n, gap, feature});
}

}  // namespace gelenk
