// SPDX-License-Identifier: BSD-3-Clause
// From the points that an iteration has found to the features that touch, and their normal.
#include <Eigen/Geometry>
#include <algorithm>

#include "collision/convex.h"

namespace gelenk {
namespace {

// Directions within the surfaces of both bodies at the closest points: the normal is perpendicular to all of them.
class Tangents {
 public:
  void add(const Eigen::Vector3d& e) {
    const double length = e.norm();
    if (length > 0 && count_ < most) directions_[static_cast<std::size_t>(count_++)] = e / length;
  }
  int count() const { return count_; }
  const Eigen::Vector3d& operator[](int i) const { return directions_[static_cast<std::size_t>(i)]; }

 private:
  static constexpr int most = 8;
  std::array<Eigen::Vector3d, most> directions_;
  int count_ = 0;
};

void add_edges(Tangents& out, const ClosestPoints& found, Support Difference::* of) {
  for (int i = 1; i < found.count; ++i) {
    for (int k = 0; k < i; ++k) {
      const Support& p = found.by[static_cast<std::size_t>(i)].*of;
      const Support& q = found.by[static_cast<std::size_t>(k)].*of;
      if (p.vertex >= 0 && p.vertex != q.vertex) out.add(p.p - q.p);
    }
  }
}

class Refinement {
 public:
  Refinement(const ConvexBody& A, const ConvexBody& B, ClosestPoints& found)
      : A_(A), B_(B), found_(found), start_(found.n), best_(separation(A, B, found.n)) {}

  double best() const { return best_; }

  // Takes a direction if the bodies are separated farther along it: whatever it comes from, it is then closer to the
  // direction of contact.
  void propose(const Eigen::Vector3d& direction) {
    const double length = direction.norm();
    if (!(length > 0)) return;
    Eigen::Vector3d n = direction / length;
    if (n.dot(start_) < 0) n = -n;
    const double distance = separation(A_, B_, n);
    if (!(distance >= best_)) return;
    best_ = distance;
    found_.n = n;
  }

 private:
  const ConvexBody& A_;
  const ConvexBody& B_;
  ClosestPoints& found_;
  Eigen::Vector3d start_;
  double best_;
};

}  // namespace

void refine(const ConvexBody& A, const ConvexBody& B, ClosestPoints& found) {
  Refinement refinement(A, B, found);
  Tangents edges;
  add_edges(edges, found, &Difference::a);
  add_edges(edges, found, &Difference::b);
  const Eigen::Vector3d d = found.by[0].w;
  if (edges.count() == 0) refinement.propose(d);
  for (int i = 0; i < edges.count(); ++i) {
    refinement.propose(d - d.dot(edges[i]) * edges[i]);
    for (int k = 0; k < i; ++k) {
      const Eigen::Vector3d cross = edges[i].cross(edges[k]);
      // Of parallel edges this is only rounding errors.
      if (cross.norm() > 1e-9) refinement.propose(cross);
    }
  }
  found.distance = refinement.best();
}

}  // namespace gelenk
