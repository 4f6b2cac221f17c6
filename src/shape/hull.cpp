// SPDX-License-Identifier: BSD-3-Clause
#include "shape/hull.h"

#include <algorithm>
#include <utility>

namespace gelenk {
namespace {

std::vector<Eigen::Vector3d> tetrahedron() {
  return {Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()};
}

}  // namespace

std::vector<Triangle> triangles_of(const Polyhedron& solid) {
  std::vector<Triangle> out;
  for (std::size_t f = 0; f < solid.faces.size(); ++f) {
    const std::span<const int> loop = solid.loop(f);
    for (std::size_t i = 2; i < loop.size(); ++i) out.push_back({loop[0], loop[i - 1], loop[i]});
  }
  return out;
}

Hull::Hull() : Hull(tetrahedron()) {}

Hull::Hull(std::vector<Eigen::Vector3d> points) {
  Data data;
  data.polyhedron = convex_hull(points);
  data.points = std::move(points);
  data.mass = integrate_over_mesh(data.polyhedron.vertices, triangles_of(data.polyhedron));
  for (const Eigen::Vector3d& vertex : data.polyhedron.vertices)
    data.size = std::max(data.size, 2 * (vertex - data.mass.center).norm());
  data_ = std::make_shared<const Data>(std::move(data));
}

Aabb Hull::bounds(const Pose3& X_WS) const {
  const std::vector<Eigen::Vector3d>& vertices = polyhedron().vertices;
  Aabb out{X_WS.point(vertices[0]), X_WS.point(vertices[0])};
  for (const Eigen::Vector3d& vertex : vertices) {
    const Eigen::Vector3d p = X_WS.point(vertex);
    out.lower = out.lower.cwiseMin(p);
    out.upper = out.upper.cwiseMax(p);
  }
  return out;
}

}  // namespace gelenk
