// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "shape/polyhedron.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Volume, first and second moments about a point of the tetrahedra between this point and each triangle.
struct Moments {
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

Moments moments_about(const Eigen::Vector3d& origin, std::span<const Eigen::Vector3d> vertices,
                      std::span<const Triangle> triangles) {
  Moments out;
  for (const Triangle& t : triangles) {
    std::array<Eigen::Vector3d, 3> p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = vertices[static_cast<std::size_t>(t[i])] - origin;
    const double V = p[0].dot(p[1].cross(p[2])) / 6;
    const Eigen::Vector3d sum = p[0] + p[1] + p[2];
    Eigen::Matrix3d squares = sum * sum.transpose();
    for (const Eigen::Vector3d& x : p) squares += x * x.transpose();
    out.volume += V;
    out.first += V / 4 * sum;
    out.second += V / 20 * squares;
  }
  return out;
}

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument(what); }

std::string point_text(const Eigen::Vector3d& p) {
  return "[" + text::rounded(p.x()) + ", " + text::rounded(p.y()) + ", " + text::rounded(p.z()) + "]";
}

void check_indices(std::span<const Eigen::Vector3d> vertices, std::span<const Triangle> triangles) {
  for (std::size_t i = 0; i < vertices.size(); ++i)
    if (!vertices[i].allFinite()) refuse("vertex " + std::to_string(i) + " of the mesh is not finite");
  if (triangles.empty()) refuse("the mesh has no triangles");
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (const int v : triangles[i]) {
      if (v >= 0 && static_cast<std::size_t>(v) < vertices.size()) continue;
      refuse("triangle " + std::to_string(i) + " of the mesh refers to vertex " + std::to_string(v) +
             ", but there are " + std::to_string(vertices.size()) + " vertices");
    }
  }
}

void check_closed(std::span<const Eigen::Vector3d> vertices, std::span<const Triangle> triangles) {
  const auto edge_text = [&](int a, int b) {
    return "the edge between vertices " + std::to_string(a) + " and " + std::to_string(b) + ", from " +
           point_text(vertices[static_cast<std::size_t>(a)]) + " to " +
           point_text(vertices[static_cast<std::size_t>(b)]) + ",";
  };
  std::map<std::pair<int, int>, int> count;
  for (const Triangle& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) ++count[{t[i], t[(i + 1) % 3]}];
  for (const auto& [edge, uses] : count) {
    const int a = edge.first;
    const int b = edge.second;
    if (a == b) refuse("the mesh has a triangle in which vertex " + std::to_string(a) + " appears twice");
    const auto reverse = count.find({b, a});
    const int back = reverse == count.end() ? 0 : reverse->second;
    if (uses == back) continue;
    if (uses + back == 1) refuse("the mesh is not closed: " + edge_text(a, b) + " belongs to one triangle only");
    if ((uses + back) % 2 != 0)
      refuse("the mesh is not closed: " + edge_text(a, b) + " belongs to " + std::to_string(uses + back) +
             " triangles");
    refuse("the triangles of the mesh are not oriented consistently: those at " + edge_text(a, b) +
           " have it in the same direction");
  }
}

}  // namespace

MassProperties integrate_over_mesh(std::span<const Eigen::Vector3d> vertices, std::span<const Triangle> triangles) {
  // First about the mean of the vertices, then about the center of mass, so that no digits cancel for a small solid far
  // from the origin.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& v : vertices) origin += v / static_cast<double>(vertices.size());
  for (int i = 0; i < 2; ++i) {
    const Moments about = moments_about(origin, vertices, triangles);
    if (about.volume > 0) origin += about.first / about.volume;
  }
  const Moments about = moments_about(origin, vertices, triangles);
  const Eigen::Matrix3d I = about.second.trace() * Eigen::Matrix3d::Identity() - about.second;
  return {about.volume, origin, I};
}

MassProperties mass_properties_of_mesh(std::span<const Eigen::Vector3d> vertices, std::span<const Triangle> triangles) {
  check_indices(vertices, triangles);
  check_closed(vertices, triangles);
  const MassProperties out = integrate_over_mesh(vertices, triangles);
  if (out.volume < 0)
    refuse("the triangles of the mesh are oriented inward (volume " + text::rounded(out.volume) +
           " m3): seen from outside, the vertices of each must be counterclockwise");
  if (!(out.volume > 0)) refuse("the mesh encloses no volume");
  return out;
}

}  // namespace gelenk
