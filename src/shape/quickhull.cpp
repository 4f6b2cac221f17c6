// SPDX-License-Identifier: BSD-3-Clause
#include "shape/quickhull.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace gelenk {
namespace {

constexpr std::array<int, 3> successor = {1, 2, 0};

}  // namespace

bool Quickhull::set_plane(Facet& of) const {
  const Eigen::Vector3d& a = at(of.vertex[0]);
  const Eigen::Vector3d& b = at(of.vertex[1]);
  const Eigen::Vector3d& c = at(of.vertex[2]);
  const Eigen::Vector3d cross = (b - a).cross(c - a);
  const double twice_area = cross.norm();
  // Lower than the tolerance, a triangle has no reliable normal.
  const double base = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  if (!(twice_area > 0.5 * tolerance_ * base)) return false;
  of.normal = cross / twice_area;
  of.area = twice_area / 2;
  of.offset = of.normal.dot(a + b + c) / 3;
  return true;
}

// The points with the least and the largest coordinate along each axis.
std::array<int, 6> Quickhull::extremes() const {
  std::array<int, 6> out{};
  for (int i = 0; i < static_cast<int>(points_.size()); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      if (at(i)(axis) < at(out[2 * k])(axis)) out[2 * k] = i;
      if (at(i)(axis) > at(out[2 * k + 1])(axis)) out[2 * k + 1] = i;
    }
  }
  return out;
}

// A tetrahedron of far points.
bool Quickhull::start() {
  const int n = static_cast<int>(points_.size());
  const std::array<int, 6> far = extremes();
  std::array<int, 4> corner{};
  double best = 0;
  for (const int a : far) {
    for (const int b : far) {
      const double length = (at(b) - at(a)).norm();
      if (length <= best) continue;
      best = length;
      corner[0] = a;
      corner[1] = b;
    }
  }
  if (!(best > tolerance_)) return false;
  const Eigen::Vector3d axis = (at(corner[1]) - at(corner[0])).normalized();
  best = 0;
  for (int i = 0; i < n; ++i) {
    const double distance = axis.cross(at(i) - at(corner[0])).norm();
    if (distance > best) {
      best = distance;
      corner[2] = i;
    }
  }
  if (!(best > tolerance_)) return false;
  const Eigen::Vector3d normal = axis.cross(at(corner[2]) - at(corner[0])).normalized();
  best = 0;
  for (int i = 0; i < n; ++i) {
    const double distance = normal.dot(at(i) - at(corner[0]));
    if (std::abs(distance) > std::abs(best)) {
      best = distance;
      corner[3] = i;
    }
  }
  if (!(std::abs(best) > 2 * tolerance_)) return false;
  if (best > 0) std::swap(corner[1], corner[2]);
  const auto [a, b, c, d] = corner;
  facets_.resize(4);
  facets_[0].vertex = {a, b, c};
  facets_[0].neighbor = {1, 2, 3};
  facets_[1].vertex = {b, a, d};
  facets_[1].neighbor = {0, 3, 2};
  facets_[2].vertex = {c, b, d};
  facets_[2].neighbor = {0, 1, 3};
  facets_[3].vertex = {a, c, d};
  facets_[3].neighbor = {0, 2, 1};
  if (!std::ranges::all_of(facets_, [this](Facet& f) { return set_plane(f); })) return false;
  constexpr std::array<int, 4> all = {0, 1, 2, 3};
  for (int i = 0; i < n; ++i) assign(i, all);
  return true;
}

// Hands a point to the facet that it is farthest above; a point above none is inside.
void Quickhull::assign(int point, std::span<const int> among) {
  int best = -1;
  double most = tolerance_;
  for (const int f : among) {
    const double above = height(facet(f), at(point));
    if (above <= most) continue;
    most = above;
    best = f;
  }
  if (best >= 0) facet(best).outside.push_back(point);
}

// Facets in whose plane the eye is count as visible, so that every new triangle, between the eye and an edge of a facet
// well below which the eye is, has a reliable normal.
void Quickhull::remove_visible(const Eigen::Vector3d& eye, int start) {
  removed_.assign(1, start);
  horizon_.clear();
  facet(start).removed = true;
  for (std::size_t done = 0; done < removed_.size(); ++done) {
    for (std::size_t i = 0; i < 3; ++i) {
      const int next = facet(removed_[done]).neighbor[i];
      if (facet(next).removed || height(facet(next), eye) <= -tolerance_) continue;
      facet(next).removed = true;
      removed_.push_back(next);
    }
  }
  for (const int f : removed_) {
    const Facet& seen = facet(f);
    for (std::size_t i = 0; i < 3; ++i) {
      if (facet(seen.neighbor[i]).removed) continue;
      horizon_.push_back({seen.vertex[i], seen.vertex[static_cast<std::size_t>(successor[i])], seen.neighbor[i]});
    }
  }
}

// Whether the horizon is one closed polygon, which is then in order.
bool Quickhull::order_horizon() {
  if (horizon_.size() < 3) return false;
  for (std::size_t i = 0; i + 1 < horizon_.size(); ++i) {
    const auto rest = horizon_.begin() + static_cast<std::ptrdiff_t>(i) + 1;
    const auto next =
        std::find_if(rest, horizon_.end(), [&](const HorizonEdge& e) { return e.from == horizon_[i].to; });
    if (next == horizon_.end()) return false;
    std::iter_swap(rest, next);
  }
  return horizon_.back().to == horizon_.front().from;
}

bool Quickhull::add(int point, int seen_from) {
  remove_visible(at(point), seen_from);
  if (!order_horizon()) return false;
  const int first = static_cast<int>(facets_.size());
  const int n = static_cast<int>(horizon_.size());
  std::vector<int> added;
  for (int i = 0; i < n; ++i) {
    const HorizonEdge edge = horizon_[static_cast<std::size_t>(i)];
    Facet fresh;
    fresh.vertex = {edge.from, edge.to, point};
    fresh.neighbor = {edge.beyond, first + (i + 1) % n, first + (i + n - 1) % n};
    if (!set_plane(fresh)) return false;
    Facet& beyond = facet(edge.beyond);
    for (std::size_t k = 0; k < 3; ++k)
      if (beyond.vertex[k] == edge.to && beyond.vertex[static_cast<std::size_t>(successor[k])] == edge.from)
        beyond.neighbor[k] = first + i;
    facets_.push_back(std::move(fresh));
    added.push_back(first + i);
  }
  for (const int f : removed_) {
    const std::vector<int> orphans = std::move(facet(f).outside);
    facet(f).outside.clear();
    for (const int orphan : orphans)
      if (orphan != point) assign(orphan, added);
  }
  return true;
}

std::optional<std::vector<Quickhull::Facet>> Quickhull::run() {
  facets_.clear();
  if (!start()) return std::nullopt;
  for (std::size_t f = 0; f < facets_.size(); ++f) {
    if (facets_[f].removed || facets_[f].outside.empty()) continue;
    const Facet& from = facets_[f];
    const auto farthest = std::ranges::max_element(from.outside, {}, [&](int i) { return height(from, at(i)); });
    if (!add(*farthest, static_cast<int>(f))) return std::nullopt;
  }
  // Each facet gets new numbers once all removed ones are left out.
  std::vector<int> number(facets_.size(), -1);
  std::vector<Facet> out;
  for (std::size_t f = 0; f < facets_.size(); ++f) {
    if (facets_[f].removed) continue;
    number[f] = static_cast<int>(out.size());
    out.push_back(std::move(facets_[f]));
  }
  for (Facet& f : out)
    for (int& neighbor : f.neighbor) neighbor = number[static_cast<std::size_t>(neighbor)];
  // A closed surface that is convex at every edge is convex.
  for (const Facet& f : out)
    for (const int neighbor : f.neighbor)
      for (const int v : out[static_cast<std::size_t>(neighbor)].vertex)
        if (height(f, at(v)) > 4 * tolerance_) return std::nullopt;
  return out;
}

}  // namespace gelenk
