// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>

#include "shape/polyhedron.h"
#include "shape/quickhull.h"
#include "util/text.h"

namespace gelenk {
namespace {

using Facet = Quickhull::Facet;
using Points = std::span<const Eigen::Vector3d>;

// Numbers the flat faces to which the triangles belong: from the largest triangle on, neighbors whose points are in its
// plane join it.
std::vector<int> flat_groups(Points points, const std::vector<Facet>& facets, double tolerance, int& count) {
  std::vector<std::size_t> order(facets.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](std::size_t f, std::size_t g) {
    return facets[f].area > facets[g].area || (facets[f].area == facets[g].area && f < g);
  });
  std::vector<int> group(facets.size(), -1);
  count = 0;
  std::vector<std::size_t> members;
  for (const std::size_t seed : order) {
    if (group[seed] >= 0) continue;
    group[seed] = count;
    members.assign(1, seed);
    for (std::size_t done = 0; done < members.size(); ++done) {
      for (const int next : facets[members[done]].neighbor) {
        const auto n = static_cast<std::size_t>(next);
        if (group[n] >= 0) continue;
        const bool flat =
            facets[n].normal.dot(facets[seed].normal) > 0 && std::ranges::all_of(facets[n].vertex, [&](int v) {
              const Eigen::Vector3d& p = points[static_cast<std::size_t>(v)];
              return std::abs(facets[seed].normal.dot(p) - facets[seed].offset) <= tolerance;
            });
        if (!flat) continue;
        group[n] = count;
        members.push_back(n);
      }
    }
    ++count;
  }
  return group;
}

// The boundary of each group as a list of points; empty if one is not a simple polygon.
std::vector<std::vector<int>> boundaries(const std::vector<Facet>& facets, const std::vector<int>& group, int count) {
  std::vector<std::map<int, int>> next(static_cast<std::size_t>(count));
  for (std::size_t f = 0; f < facets.size(); ++f) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (group[static_cast<std::size_t>(facets[f].neighbor[i])] == group[f]) continue;
      const auto [at, fresh] =
          next[static_cast<std::size_t>(group[f])].emplace(facets[f].vertex[i], facets[f].vertex[(i + 1) % 3]);
      if (!fresh) return {};
    }
  }
  std::vector<std::vector<int>> out;
  for (const std::map<int, int>& successor : next) {
    if (successor.empty()) return {};
    std::vector<int> loop = {successor.begin()->first};
    while (loop.size() <= successor.size()) {
      const auto found = successor.find(loop.back());
      if (found == successor.end()) return {};
      if (found->second == loop.front()) break;
      loop.push_back(found->second);
    }
    if (loop.size() != successor.size()) return {};
    out.push_back(std::move(loop));
  }
  return out;
}

// Keeps the corners, the points at which three faces or more meet; the others are within an edge.
bool keep_corners(std::vector<std::vector<int>>& loops) {
  std::map<int, int> faces_at;
  for (const std::vector<int>& loop : loops)
    for (const int v : loop) ++faces_at[v];
  for (std::vector<int>& loop : loops) {
    std::erase_if(loop, [&](int v) { return faces_at[v] < 3; });
    if (loop.size() < 3) return false;
  }
  return true;
}

void set_planes(Polyhedron& solid) {
  for (std::size_t f = 0; f < solid.faces.size(); ++f) {
    Polyhedron::Face& face = solid.faces[f];
    const std::span<const int> loop = solid.loop(f);
    const Eigen::Vector3d& origin = solid.vertices[static_cast<std::size_t>(loop[0])];
    Eigen::Vector3d twice_area = Eigen::Vector3d::Zero();
    for (std::size_t i = 2; i < loop.size(); ++i)
      twice_area += (solid.vertices[static_cast<std::size_t>(loop[i - 1])] - origin)
                        .cross(solid.vertices[static_cast<std::size_t>(loop[i])] - origin);
    face.normal = twice_area.normalized();
    face.offset = -std::numeric_limits<double>::infinity();
    for (const int v : loop)
      face.offset = std::max(face.offset, face.normal.dot(solid.vertices[static_cast<std::size_t>(v)]));
  }
}

// Finds the edges and neighbors; false if the faces do not close.
bool connect(Polyhedron& solid) {
  std::map<std::pair<int, int>, std::pair<int, std::size_t>> half_edges;  // face and place in loops
  for (std::size_t f = 0; f < solid.faces.size(); ++f) {
    const std::span<const int> loop = solid.loop(f);
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const auto place = static_cast<std::size_t>(solid.faces[f].first) + i;
      if (!half_edges.emplace(std::pair(loop[i], loop[(i + 1) % loop.size()]), std::pair(static_cast<int>(f), place))
               .second)
        return false;
    }
  }
  solid.loop_edges.assign(solid.loops.size(), 0);
  std::vector<std::set<int>> adjacent(solid.vertices.size());
  for (const auto& [ends, half] : half_edges) {
    const auto other = half_edges.find({ends.second, ends.first});
    if (other == half_edges.end()) return false;
    if (ends.first > ends.second) continue;
    const int number = static_cast<int>(solid.edges.size());
    solid.loop_edges[half.second] = number;
    solid.loop_edges[other->second.second] = number;
    solid.edges.push_back({{ends.first, ends.second}, {half.first, other->second.first}});
    adjacent[static_cast<std::size_t>(ends.first)].insert(ends.second);
    adjacent[static_cast<std::size_t>(ends.second)].insert(ends.first);
  }
  for (const std::set<int>& of : adjacent) {
    solid.first_neighbor.push_back(static_cast<int>(solid.neighbors.size()));
    solid.neighbors.insert(solid.neighbors.end(), of.begin(), of.end());
  }
  solid.first_neighbor.push_back(static_cast<int>(solid.neighbors.size()));
  return solid.vertices.size() + solid.faces.size() == solid.edges.size() + 2;  // Euler
}

std::optional<Polyhedron> assemble(Points points, const std::vector<Facet>& facets, double tolerance) {
  int count = 0;
  const std::vector<int> group = flat_groups(points, facets, tolerance, count);
  std::vector<std::vector<int>> loops = boundaries(facets, group, count);
  if (loops.empty() || !keep_corners(loops)) return std::nullopt;
  std::map<int, int> number;
  for (const std::vector<int>& loop : loops)
    for (const int v : loop) number[v] = 0;
  Polyhedron out;
  for (auto& [point, vertex] : number) {
    vertex = static_cast<int>(out.vertices.size());
    out.vertices.push_back(points[static_cast<std::size_t>(point)]);
  }
  for (const std::vector<int>& loop : loops) {
    out.faces.push_back({.first = static_cast<int>(out.loops.size()), .count = static_cast<int>(loop.size())});
    for (const int v : loop) out.loops.push_back(number[v]);
  }
  set_planes(out);
  if (!connect(out)) return std::nullopt;
  return out;
}

}  // namespace

int Polyhedron::farthest(const Eigen::Vector3d& d) const {
  // Below this number of vertices, looking at all of them is faster than walking along edges.
  constexpr std::size_t few = 32;
  int best = 0;
  double reach = d.dot(vertices[0]);
  if (vertices.size() <= few) {
    for (std::size_t i = 1; i < vertices.size(); ++i) {
      const double x = d.dot(vertices[i]);
      if (x <= reach) continue;
      reach = x;
      best = static_cast<int>(i);
    }
    return best;
  }
  for (int from = -1; from != best;) {
    from = best;
    const auto at = static_cast<std::size_t>(from);
    for (int k = first_neighbor[at]; k < first_neighbor[at + 1]; ++k) {
      const int v = neighbors[static_cast<std::size_t>(k)];
      const double x = d.dot(vertices[static_cast<std::size_t>(v)]);
      if (x <= reach) continue;
      reach = x;
      best = v;
    }
  }
  return best;
}

Polyhedron convex_hull(Points points) {
  if (points.size() < 4)
    throw std::invalid_argument("a hull needs 4 points or more that are not in one plane, found " +
                                std::to_string(points.size()));
  Eigen::Vector3d lower = points[0];
  Eigen::Vector3d upper = points[0];
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite())
      throw std::invalid_argument("point " + std::to_string(i + 1) + " of the hull is not finite");
    lower = lower.cwiseMin(points[i]);
    upper = upper.cwiseMax(points[i]);
  }
  const double extent = (upper - lower).norm();
  // Single precision: 2^-24 relative to each of three coordinates. Sets with clusters of nearly coinciding points may
  // need more.
  double relative = 1e-7;
  for (int attempt = 0; attempt < 4; ++attempt, relative *= 4) {
    const double tolerance = relative * extent;
    const std::optional<std::vector<Facet>> facets = Quickhull(points, tolerance).run();
    if (!facets) continue;
    if (std::optional<Polyhedron> solid = assemble(points, *facets, tolerance)) return *std::move(solid);
  }
  throw std::invalid_argument("the " + std::to_string(points.size()) +
                              " points of the hull are in one plane or nearly so (extent " + text::rounded(extent, 3) +
                              " m)");
}

}  // namespace gelenk
