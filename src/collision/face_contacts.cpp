// SPDX-License-Identifier: BSD-3-Clause
#include "collision/face_contacts.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace gelenk {
namespace {

// Corners this close to an edge, relative to the smaller body, are on it; so rounding errors do not decide which of two
// equal faces in the same place a corner belongs to.
constexpr double relative_slack = 1e-6;

struct Facing {
  const Solid& A;
  const Solid& B;
  Eigen::Vector3d n;
  int a, b;                  // faces
  Eigen::Vector3d n_A, n_B;  // their outer normals
  double slack, least;
  ContactSet& out;

  void add_corners_of_B() const {
    if (n_A.dot(n) < facing) return;
    for (const int v : B.loop(b)) {
      const Eigen::Vector3d x = B.vertex(v);
      const double gap = A.height(a, n_A, x);
      if (gap > out.margin() || gap < least || !A.covers(a, n_A, x, slack)) continue;
      out.add_above(x, n_A, gap, pair_feature(A.face_feature(a), v, B.feature_count()));
    }
  }
  void add_corners_of_A() const {
    if (-n_B.dot(n) < facing) return;
    for (const int v : A.loop(a)) {
      const Eigen::Vector3d x = A.vertex(v);
      const double gap = B.height(b, n_B, x);
      if (gap > out.margin() || gap < least || !B.covers(b, n_B, x, slack) || is_corner_of_B(x)) continue;
      out.add_below(x, -n_B, gap, pair_feature(v, B.face_feature(b), B.feature_count()));
    }
  }
  // Whether a corner of B, which has been added, is next to x.
  bool is_corner_of_B(const Eigen::Vector3d& x) const {
    if (n_A.dot(n) < facing) return false;
    return std::ranges::any_of(B.loop(b), [&](int v) { return n.cross(B.vertex(v) - x).norm() <= 2 * slack; });
  }
  void add_crossings() const {
    const std::span<const int> loop_A = A.loop(a);
    const std::span<const int> loop_B = B.loop(b);
    for (std::size_t i = 0; i < loop_A.size(); ++i) {
      const Eigen::Vector3d from = A.vertex(loop_A[i]);
      const Eigen::Vector3d along = A.vertex(loop_A[(i + 1) % loop_A.size()]) - from;
      const int feature = A.edge_feature(A.edge_at(a, i));
      for (std::size_t k = 0; k < loop_B.size(); ++k) {
        const Eigen::Vector3d to = B.vertex(loop_B[k]);
        const Eigen::Vector3d along_B = B.vertex(loop_B[(k + 1) % loop_B.size()]) - to;
        add_crossing(from, along, to, along_B,
                     pair_feature(feature, B.edge_feature(B.edge_at(b, k)), B.feature_count()));
      }
    }
  }
  void add_crossing(const Eigen::Vector3d& p, const Eigen::Vector3d& along_A, const Eigen::Vector3d& q,
                    const Eigen::Vector3d& along_B, int feature) const {
    const Eigen::Vector3d cross = along_A.cross(along_B);
    const double sine = cross.norm();
    const double length_A = along_A.norm();
    const double length_B = along_B.norm();
    if (!(sine > relative_slack * length_A * length_B)) return;
    Eigen::Vector3d normal = cross / sine;
    if (normal.dot(n) < 0) normal = -normal;
    if (normal.dot(n) < facing) return;
    const Eigen::Vector3d d = q - p;
    // Closest points p + s along_A and q + t along_B.
    const double s = d.dot(along_B.cross(cross)) / (sine * sine);
    const double t = d.dot(along_A.cross(cross)) / (sine * sine);
    const auto is_between = [&](double x, double length) { return x * length > slack && (1 - x) * length > slack; };
    if (!is_between(s, length_A) || !is_between(t, length_B)) return;
    const double gap = normal.dot(d);
    if (gap >= least) out.add_above(q + t * along_B, normal, gap, feature);
  }
};

}  // namespace

void face_contacts(const Solid& A, const Solid& B, const Eigen::Vector3d& n, double distance, ContactSet& out) {
  const int a = A.face_toward(n);
  const int b = B.face_toward(-n);
  const double size = std::min(A.size(), B.size());
  const Facing both{A,  B, n, a, b, A.normal(a), B.normal(b), relative_slack * size, distance - same_contact * size,
                    out};
  if (both.n_A.dot(n) < facing && -both.n_B.dot(n) < facing) return;
  both.add_corners_of_B();
  both.add_corners_of_A();
  both.add_crossings();
}

}  // namespace gelenk
