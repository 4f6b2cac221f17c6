// SPDX-License-Identifier: BSD-3-Clause
// The distance of convex bodies (Gilbert, Johnson & Keerthi 1988).
#include "collision/convex.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "collision/simplex.h"

namespace gelenk {

ConvexBody::ConvexBody(const AnyShape& shape, const Pose3& X) : center_(X.p) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) {
    radius_ = sphere->radius;
  } else if (const auto* capsule = std::get_if<Capsule>(&shape)) {
    core_ = Axis{X.R.col(2), capsule->length / 2};
    radius_ = capsule->radius;
    size_ = capsule->length;
  } else if (const auto* box = std::get_if<Box>(&shape)) {
    core_.emplace<Solid>(*box, X);
    size_ = box->size();
  } else if (const auto* hull = std::get_if<Hull>(&shape)) {
    core_.emplace<Solid>(*hull, X);
    center_ = X.point(hull->mass_properties().center);
    size_ = hull->size();
  } else if (const auto* mesh = std::get_if<Mesh>(&shape)) {
    core_.emplace<Solid>(mesh->hull(), X);
    center_ = X.point(mesh->hull().mass_properties().center);
    size_ = mesh->size();
  } else if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
    core_.emplace<CylinderPose>(*cylinder, X);
    size_ = cylinder->size();
  } else if (const auto* wheel = std::get_if<Wheel>(&shape)) {
    core_.emplace<CylinderPose>(Cylinder{wheel->disk(), 0}, X);
    radius_ = wheel->crown;
    size_ = 2 * wheel->disk();
  }
}

Support ConvexBody::support(const Eigen::Vector3d& d) const {
  if (const auto* of = solid()) {
    const int v = of->farthest(d);
    return {of->vertex(v), v};
  }
  if (const auto* of = segment()) {
    const int end = of->along.dot(d) < 0 ? 0 : 1;
    return {center_ + (end == 0 ? -of->half : of->half) * of->along, end};
  }
  if (const auto* of = cylinder()) {
    const double x = d.dot(of->x);
    const double y = d.dot(of->y);
    const double across = std::hypot(x, y);
    const Eigen::Vector3d cap = of->cap(d.dot(of->axis) < 0 ? 0 : 1);
    if (!(across > 0)) return {cap + of->radius * of->x, -1};
    return {cap + of->radius * (x / across * of->x + y / across * of->y), -1};
  }
  return {center_, 0};
}

int ConvexBody::feature_count() const {
  if (const auto* of = solid()) return of->feature_count();
  if (segment() != nullptr) return 3;
  return cylinder() != nullptr ? cylinder_feature::count : 1;
}

Difference difference(const ConvexBody& A, const ConvexBody& B, const Eigen::Vector3d& n) {
  Difference out{.a = A.support(n), .b = B.support(-n)};
  out.w = out.b.p - out.a.p;
  return out;
}

double separation(const ConvexBody& A, const ConvexBody& B, const Eigen::Vector3d& n) {
  return n.dot(difference(A, B, n).w);
}

namespace {

class Gjk {
 public:
  Gjk(const ConvexBody& A, const ConvexBody& B, double limit)
      : A_(A), B_(B), limit_(limit), touching_(1e-10 * std::max(A.size(), B.size())) {}

  std::optional<ClosestPoints> run() {
    Eigen::Vector3d v = B_.center() - A_.center();
    if (!(v.norm() > 0)) v = Eigen::Vector3d::UnitZ();
    v = difference(A_, B_, v).w;
    // Curved surfaces need about 20 steps; polyhedra fewer than they have vertices around the closest points.
    constexpr int most_steps = 100;
    for (int step = 0; step < most_steps; ++step) {
      const double distance = v.norm();
      if (count_ > 0 && distance <= touching_) break;
      const Difference next =
          difference(A_, B_, distance > 0 ? Eigen::Vector3d(v / distance) : Eigen::Vector3d::UnitZ());
      const double bound = distance > 0 ? v.dot(next.w) / distance : 0;
      if (bound > limit_) return std::nullopt;
      // The distance is between the bound and the length of v.
      constexpr double precision = 1e-14;
      if (count_ > 0 && (distance - bound <= precision * distance || is_known(next))) return closest(v);
      if (!add(next)) return closest(v);
      if (count_ == 4) break;
      const Eigen::Vector3d moved = current_.p;
      if (step > 0 && moved.norm() >= distance) return closest(v);
      v = moved;
    }
    if (count_ < 4 && v.norm() > touching_) return closest(v);
    ClosestPoints deep = penetration(A_, B_, simplex_, count_);
    return deep;
  }

 private:
  bool is_known(const Difference& next) const {
    return std::any_of(simplex_.begin(), simplex_.begin() + count_,
                       [&](const Difference& known) { return known.w == next.w; });
  }
  // Adds a point and leaves out those that are not needed.
  bool add(const Difference& next) {
    const std::array<Difference, 4> before = simplex_;
    const int count_before = count_;
    const SimplexPoint current_before = current_;
    simplex_[static_cast<std::size_t>(count_++)] = next;
    std::array<Eigen::Vector3d, 4> w;
    for (std::size_t i = 0; i < 4; ++i) w[i] = simplex_[i].w;
    current_ = closest_to_origin(w, count_);
    if (count_before > 0 && current_.p.squaredNorm() >= current_before.p.squaredNorm()) {
      simplex_ = before;
      count_ = count_before;
      current_ = current_before;
      return false;
    }
    int kept = 0;
    for (int i = 0; i < count_; ++i) {
      const auto from = static_cast<std::size_t>(i);
      if (!(current_.weights[from] > 0)) continue;
      simplex_[static_cast<std::size_t>(kept)] = simplex_[from];
      current_.weights[static_cast<std::size_t>(kept++)] = current_.weights[from];
    }
    count_ = kept;
    return true;
  }
  ClosestPoints closest(const Eigen::Vector3d& v) const {
    ClosestPoints out;
    out.distance = v.norm();
    out.n = v / out.distance;
    out.count = std::min(count_, 3);
    for (int i = 0; i < out.count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      out.by[k] = simplex_[k];
      out.weights[k] = current_.weights[k];
    }
    return out;
  }

  const ConvexBody& A_;
  const ConvexBody& B_;
  double limit_, touching_;
  std::array<Difference, 4> simplex_;
  int count_ = 0;
  SimplexPoint current_;
};

}  // namespace

std::optional<ClosestPoints> closest_points(const ConvexBody& A, const ConvexBody& B, double limit) {
  std::optional<ClosestPoints> found = Gjk(A, B, limit).run();
  if (!found) return found;
  refine(A, B, *found);
  if (found->distance > limit) return std::nullopt;
  return found;
}

}  // namespace gelenk
