// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/export/outline.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "shape/registry.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

// Beyond this number of triangles, a drawing in a page would be larger than the page.
constexpr std::size_t max_triangles = 2000;

// The face of a convex shape: its points farthest in directions across the view.
std::vector<Vector3d> silhouette(const AnyShape& shape, const Pose3& X_WS, const Vector3d& right, const Vector3d& up) {
  constexpr int directions = 96;
  std::vector<Vector3d> out;
  for (int i = 0; i < directions; ++i) {
    // Not along axes: there, the farthest point of a box would be one of several.
    const double angle = 2 * std::numbers::pi * (i + 0.37) / directions;
    const Vector3d d = X_WS.R.transpose() * (std::cos(angle) * right + std::sin(angle) * up);
    const Vector3d p = X_WS.point(*support(shape, d));
    if (out.empty() || p != out.back()) out.push_back(p);
  }
  return out;
}

Outline outline_of_triangles(const AnyShape& shape, const Pose3& X_WS, const Vector3d& towards) {
  std::vector<Vector3d> points;
  for (const Vector3d& p : points_of(shape)) points.push_back(X_WS.point(p));
  const auto at = [&](int i) { return points[static_cast<std::size_t>(i)]; };
  Outline out;
  std::map<std::pair<int, int>, int> edges;  // of visible triangles, those of two of them cancel
  for (const Triangle& t : triangles_of(shape)) {
    const Vector3d a = at(t[0]);
    if (!((at(t[1]) - a).cross(at(t[2]) - a).dot(towards) > 0)) continue;
    out.faces.push_back({a, at(t[1]), at(t[2])});
    for (std::size_t i = 0; i < 3; ++i) {
      const auto edge = std::minmax(t[i], t[(i + 1) % 3]);
      ++edges[{edge.first, edge.second}];
    }
  }
  for (const auto& [edge, uses] : edges)
    if (uses == 1) out.lines.push_back({at(edge.first), at(edge.second)});
  return out;
}

}  // namespace

Outline outline_of(const AnyShape& shape, const Pose3& X_WS, const Vector3d& right, const Vector3d& up) {
  if (!kind_of(shape).bounded) return {};
  const std::size_t triangles = triangles_of(shape).size();
  if (triangles > 0 && triangles <= max_triangles) return outline_of_triangles(shape, X_WS, right.cross(up));
  Outline out;
  out.faces.push_back(silhouette(shape, X_WS, right, up));
  return out;
}

}  // namespace gelenk
