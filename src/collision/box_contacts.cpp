// SPDX-License-Identifier: BSD-3-Clause
// Two boxes: the axis of least overlap (Gottschalk, Lin & Manocha 1996), then the faces around it.
#include <Eigen/Geometry>
#include <limits>

#include "collision/face_contacts.h"
#include "collision/pairs.h"

namespace gelenk {
namespace {

struct Separation {
  double distance = -std::numeric_limits<double>::infinity();
  Eigen::Vector3d n = Eigen::Vector3d::UnitZ();
  int edge_A = -1;  // axis along which the edges are that touch; -1: a face touches
  int edge_B = -1;
};

class BoxAxes {
 public:
  BoxAxes(const Box& A, const Pose3& X_A, const Box& B, const Pose3& X_B)
      : A_(X_A.R), B_(X_B.R), half_A_(A.lengths / 2), half_B_(B.lengths / 2), d_(X_B.p - X_A.p) {
    for (Eigen::Index i = 0; i < 3; ++i) try_axis(A_.col(i), -1, -1);
    for (Eigen::Index i = 0; i < 3; ++i) try_axis(B_.col(i), -1, -1);
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d cross = A_.col(i).cross(B_.col(k));
        const double sine = cross.norm();
        // Of parallel edges the cross product is only rounding errors, and axes of faces suffice.
        if (sine > 1e-12) try_axis(cross / sine, i, k);
      }
    }
  }
  const Separation& best() const { return best_; }

 private:
  void try_axis(const Eigen::Vector3d& n, int edge_A, int edge_B) {
    const double along = n.dot(d_);
    const double reach = half_A_.dot((A_.transpose() * n).cwiseAbs()) + half_B_.dot((B_.transpose() * n).cwiseAbs());
    const double distance = std::abs(along) - reach;
    // An axis of two edges must be better by more than rounding errors.
    const double better = edge_A >= 0 ? 1e-14 * reach : 0;
    if (distance > best_.distance + better) best_ = {distance, along < 0 ? Eigen::Vector3d(-n) : n, edge_A, edge_B};
  }

  Eigen::Matrix3d A_, B_;
  Eigen::Vector3d half_A_, half_B_, d_;
  Separation best_;
};

// The edge along an axis of a box that is farthest in the direction n: its middle and the numbers of its ends.
struct BoxEdge {
  BoxEdge(const Box& box, const Pose3& X, int axis, const Eigen::Vector3d& n) {
    const Eigen::Vector3d local = X.R.transpose() * n;
    int corner = 0;
    for (int i = 0; i < 3; ++i)
      if (i != axis && local(i) > 0) corner |= 1 << i;
    low = corner;
    high = corner | (1 << axis);
    middle = (X.point(box.corner(low)) + X.point(box.corner(high))) / 2;
    along = X.R.col(axis);
  }
  int low = 0, high = 0;
  Eigen::Vector3d middle, along;
};

}  // namespace

void contacts(const Box& A, const Pose3& X_A, const Box& B, const Pose3& X_B, ContactSet& out) {
  const Separation found = BoxAxes(A, X_A, B, X_B).best();
  if (found.distance > out.margin()) return;
  // Corners and edges can be closer to each other than any of these axes shows.
  if (found.distance > 0) return convex_contacts(A, X_A, B, X_B, out);
  const Solid a(A, X_A);
  const Solid b(B, X_B);
  face_contacts(a, b, found.n, found.distance, out);
  // Deviations of the gaps of these points from the distance by rounding errors.
  if (out.least_gap() <= found.distance + 1e-12 * (a.size() + b.size())) return;
  if (found.edge_A < 0) return convex_contacts(A, X_A, B, X_B, out);
  const BoxEdge of_A(A, X_A, found.edge_A, found.n);
  const BoxEdge of_B(B, X_B, found.edge_B, -found.n);
  const int feature = pair_feature(a.edge_feature(a.edge_between(of_A.low, of_A.high)),
                                   b.edge_feature(b.edge_between(of_B.low, of_B.high)), b.feature_count());
  const Eigen::Vector3d cross = of_A.along.cross(of_B.along);
  const double t = (of_B.middle - of_A.middle).dot(of_A.along.cross(cross)) / cross.squaredNorm();
  out.add_above(of_B.middle + t * of_B.along, found.n, found.distance, feature);
}

}  // namespace gelenk
