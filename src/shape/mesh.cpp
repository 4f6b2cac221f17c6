// SPDX-License-Identifier: BSD-3-Clause
#include "shape/mesh.h"

#include <utility>

namespace gelenk {
namespace {

std::vector<Eigen::Vector3d> used_points(std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles) {
  std::vector<bool> used(points.size(), false);
  for (const Triangle& triangle : triangles)
    for (const int v : triangle) used[static_cast<std::size_t>(v)] = true;
  std::vector<Eigen::Vector3d> out;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (used[i]) out.push_back(points[i]);
  return out;
}

}  // namespace

Mesh::Mesh()
    : Mesh({Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()},
           {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}) {}

Mesh::Mesh(std::vector<Eigen::Vector3d> points, std::vector<Triangle> triangles) {
  Data data;
  data.mass = mass_properties_of_mesh(points, triangles);
  data.hull = Hull(used_points(points, triangles));
  data.points = std::move(points);
  data.triangles = std::move(triangles);
  data_ = std::make_shared<const Data>(std::move(data));
}

}  // namespace gelenk
