// SPDX-License-Identifier: BSD-3-Clause
// Spheres and capsules in closed form.
#include <Eigen/Geometry>
#include <algorithm>

#include "collision/cylinder.h"
#include "collision/pairs.h"

namespace gelenk {
namespace {

// Adds the contact of balls about a and b. along: the normal if the centers coincide but for rounding errors.
void add_balls(const Eigen::Vector3d& a, double radius_A, const Eigen::Vector3d& b, double radius_B,
               const Eigen::Vector3d& along, int feature, ContactSet& out) {
  constexpr double coinciding = 1e-12;  // relative to the radii
  const Eigen::Vector3d d = b - a;
  const double distance = d.stableNorm();
  const bool apart = distance > coinciding * (radius_A + radius_B);
  const Eigen::Vector3d n = apart ? Eigen::Vector3d(d.stableNormalized()) : along;
  const double gap = distance - radius_A - radius_B;
  out.add_above(b - radius_B * n, n, gap, feature);
}

struct Segment {
  Segment(const Capsule& of, const Pose3& X) : center(X.p), axis(X.R.col(2)), across(X.R.col(0)), half(of.length / 2) {}

  Eigen::Vector3d at(double z) const { return center + z * axis; }
  // Coordinate along the axis of the point closest to x.
  double closest(const Eigen::Vector3d& x) const { return std::clamp(axis.dot(x - center), -half, half); }
  double coordinate(int end) const { return end == 0 ? -half : half; }
  Eigen::Vector3d end(int end) const { return at(coordinate(end)); }
  // 0 and 1: the ends, 2: between them.
  int feature(double z) const { return z <= -half ? 0 : z >= half ? 1 : 2; }

  Eigen::Vector3d center, axis, across;
  double half;
};

constexpr int segment_features = 3;

}  // namespace

void contacts(const Sphere& A, const Pose3& X_A, const Sphere& B, const Pose3& X_B, ContactSet& out) {
  add_balls(X_A.p, A.radius, X_B.p, B.radius, Eigen::Vector3d::UnitZ(), 0, out);
}

void contacts(const Sphere& A, const Pose3& X_A, const Capsule& B, const Pose3& X_B, ContactSet& out) {
  const Segment b(B, X_B);
  const double z = b.closest(X_A.p);
  const int feature = b.feature(z);
  const Eigen::Vector3d along = feature == 0   ? Eigen::Vector3d(b.axis)
                                : feature == 1 ? Eigen::Vector3d(-b.axis)
                                               : b.across;
  add_balls(X_A.p, A.radius, b.at(z), B.radius, along, feature, out);
}

// Features are the 27 regions around a box; within the box, those of its faces.
void contacts(const Sphere& A, const Pose3& X_A, const Box& B, const Pose3& X_B, ContactSet& out) {
  const Eigen::Vector3d c = X_B.R.transpose() * (X_A.p - X_B.p);
  const Eigen::Vector3d half = B.lengths / 2;
  Eigen::Vector3d out_of = Eigen::Vector3d::Zero();  // from the box to the center
  int feature = 0;
  for (Eigen::Index i = 2; i >= 0; --i) {
    const int region = c(i) < -half(i) ? 0 : c(i) > half(i) ? 2 : 1;
    if (region != 1) out_of(i) = c(i) - std::copysign(half(i), c(i));
    feature = 3 * feature + region;
  }
  double distance = out_of.stableNorm();
  Eigen::Vector3d n_B = distance > 0 ? Eigen::Vector3d(out_of.stableNormalized()) : out_of;
  if (!(distance > 0)) {
    const Eigen::Vector3d depth = half - c.cwiseAbs();
    Eigen::Index axis = 0;
    distance = -depth.minCoeff(&axis);
    n_B(axis) = c(axis) < 0 ? -1 : 1;
    const int place = axis == 0 ? 1 : axis == 1 ? 3 : 9;
    feature = 13 + (c(axis) < 0 ? -place : place);
  }
  const Eigen::Vector3d n = -(X_B.R * n_B);
  out.add_below(X_A.p + A.radius * n, n, distance - A.radius, feature);
}

void contacts(const Sphere& A, const Pose3& X_A, const Cylinder& B, const Pose3& X_B, ContactSet& out) {
  const CylinderPose b(B, X_B);
  const Eigen::Vector3d d = X_A.p - b.center;
  const Eigen::Vector3d local(d.dot(b.x), d.dot(b.y), d.dot(b.axis));
  const double rho = std::hypot(local.x(), local.y());
  const Eigen::Vector3d radial = rho > 0 ? Eigen::Vector3d((local.x() / rho) * b.x + (local.y() / rho) * b.y) : b.x;
  const int end = local.z() < 0 ? 0 : 1;
  const Eigen::Vector3d axial = end == 0 ? Eigen::Vector3d(-b.axis) : b.axis;
  const double beyond_side = rho - b.radius;
  const double beyond_cap = std::abs(local.z()) - b.half;
  if (beyond_side > 0 && beyond_cap > 0) {
    const double distance = std::hypot(beyond_side, beyond_cap);
    const Eigen::Vector3d n = -(beyond_side / distance * radial + beyond_cap / distance * axial);
    out.add_below(X_A.p + A.radius * n, n, distance - A.radius, cylinder_feature::rim(end));
  } else if (beyond_side > beyond_cap) {
    out.add_below(X_A.p - A.radius * radial, -radial, beyond_side - A.radius, cylinder_feature::side);
  } else {
    out.add_below(X_A.p - A.radius * axial, -axial, beyond_cap - A.radius, cylinder_feature::cap(end));
  }
}

namespace {

// Closest points of two segments, as coordinates along their axes (Ericson 2005, sec. 5.1.9).
std::pair<double, double> closest(const Segment& a, const Segment& b) {
  const double c = a.axis.dot(b.axis);
  const Eigen::Vector3d d = b.center - a.center;
  const double sine2 = a.axis.cross(b.axis).squaredNorm();
  double s = 0;
  if (sine2 > 0) s = std::clamp((a.axis - c * b.axis).dot(d) / sine2, -a.half, a.half);
  const double t = b.closest(a.at(s));
  s = a.closest(b.at(t));
  return {s, b.closest(a.at(s))};
}

}  // namespace

// Features are pairs of an end or the side of each capsule.
void contacts(const Capsule& A, const Pose3& X_A, const Capsule& B, const Pose3& X_B, ContactSet& out) {
  const Segment a(A, X_A);
  const Segment b(B, X_B);
  const Eigen::Vector3d cross = a.axis.cross(b.axis);
  const double sine = cross.norm();
  // Below the first sine both axes are parallel, and closest points between the ends are not defined; below the second,
  // capsules that lie side by side also touch at the ends, so that one of them can rest on the other.
  constexpr double parallel = 1e-8;
  constexpr double nearly_parallel = 0.2;
  const Eigen::Vector3d along = sine > parallel ? Eigen::Vector3d(cross / sine) : a.across;
  const auto add = [&](double s, double t, int of_A, int of_B) {
    add_balls(a.at(s), A.radius, b.at(t), B.radius, along, of_A * segment_features + of_B, out);
  };
  const auto [s, t] = closest(a, b);
  const int of_A = a.feature(s);
  const int of_B = b.feature(t);
  const bool between = of_A == 2 && of_B == 2;
  if (sine >= nearly_parallel) return add(s, t, of_A, of_B);
  // Ends beside the other capsule; ends next to each other count once, within this part of the length.
  constexpr double slack = 1e-6;
  int ends = 0;
  const auto add_end = [&](const Eigen::Vector3d& end, double at, const Segment& other, bool is_A, int number) {
    const double foot = other.axis.dot(end - other.center);
    const double limit = is_A ? other.half * (1 + slack) : other.half * (1 - slack);
    if (std::abs(foot) > limit) return;
    ++ends;
    if (is_A) return add(at, foot, number, 2);
    add(foot, at, 2, number);
  };
  for (int end = 0; end < 2; ++end) add_end(a.end(end), a.coordinate(end), b, true, end);
  for (int end = 0; end < 2; ++end) add_end(b.end(end), b.coordinate(end), a, false, end);
  const bool crossing = between && sine > parallel;
  if (crossing || ends == 0 || (!between && of_A != 2 && of_B != 2)) add(s, t, of_A, of_B);
}

}  // namespace gelenk
