// SPDX-License-Identifier: BSD-3-Clause
#include "collision/solid.h"

#include <Eigen/Geometry>

namespace gelenk {
namespace {

const Polyhedron& unit_cube() {
  static const Polyhedron cube = [] {
    std::vector<Eigen::Vector3d> corners;
    for (int i = 0; i < 8; ++i) corners.push_back(Box().corner(i));
    return convex_hull(corners);
  }();
  return cube;
}

}  // namespace

Solid::Solid(const Box& box, const Pose3& X) : shape_(&unit_cube()), scale_(box.lengths), X_(X), size_(box.size()) {}

int Solid::face_toward(const Eigen::Vector3d& d) const {
  const Eigen::Vector3d local = X_.R.transpose() * d;
  int best = 0;
  double most = -std::numeric_limits<double>::infinity();
  for (int f = 0; f < face_count(); ++f) {
    const double along = shape_->faces[static_cast<std::size_t>(f)].normal.dot(local);
    if (along <= most) continue;
    most = along;
    best = f;
  }
  return best;
}

bool Solid::covers(int face, const Eigen::Vector3d& normal, const Eigen::Vector3d& x, double slack) const {
  const std::span<const int> around = loop(face);
  Eigen::Vector3d from = vertex(around.back());
  for (const int v : around) {
    const Eigen::Vector3d to = vertex(v);
    const Eigen::Vector3d outward = (to - from).cross(normal);
    if (outward.dot(x - from) > slack * outward.norm()) return false;
    from = to;
  }
  return true;
}

int Solid::edge_between(int a, int b) const {
  const auto [low, high] = std::minmax(a, b);
  for (std::size_t i = 0; i < shape_->edges.size(); ++i)
    if (shape_->edges[i].vertex[0] == low && shape_->edges[i].vertex[1] == high) return static_cast<int>(i);
  return -1;
}

}  // namespace gelenk
