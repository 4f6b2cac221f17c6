// SPDX-License-Identifier: BSD-3-Clause
// The expanding polytope algorithm (van den Bergen 2001): facets within the difference of two bodies are moved outward
// until the one closest to the origin is on its surface.
#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "collision/convex.h"

namespace gelenk {
namespace {

constexpr int most_points = 240;
constexpr int most_facets = 1000;
constexpr int most_edges = 160;
constexpr std::array<std::size_t, 3> successor = {1, 2, 0};

struct Facet {
  std::array<int, 3> vertex{}, neighbor{};
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double offset = 0;
  bool removed = false;
};
struct HorizonEdge {
  int from = 0, to = 0, beyond = 0;
};

class Polytope {
 public:
  Polytope(const ConvexBody& A, const ConvexBody& B)
      : A_(A),
        B_(B),
        size_(A.size() + B.size()),
        // On curved surfaces refine() does the rest.
        enough_((A.cylinder() != nullptr || B.cylinder() != nullptr ? 1e-9 : 1e-13) * size_) {}

  bool start(const std::array<Difference, 4>& points, int count);
  void expand();
  ClosestPoints closest() const;

 private:
  const Eigen::Vector3d& at(int i) const { return points_[static_cast<std::size_t>(i)].w; }
  Facet& facet(int f) { return facets_[static_cast<std::size_t>(f)]; }

  // The point of the difference farthest in the direction d.
  Difference farthest(const Eigen::Vector3d& d) const { return difference(A_, B_, -d); }
  bool add_off(const Eigen::Vector3d& direction, bool (Polytope::*is_off)(const Eigen::Vector3d&) const);
  bool off_point(const Eigen::Vector3d& x) const { return (x - at(0)).norm() > least(); }
  bool off_line(const Eigen::Vector3d& x) const {
    const Eigen::Vector3d e = at(1) - at(0);
    return e.cross(x - at(0)).norm() > least() * e.norm();
  }
  bool off_plane(const Eigen::Vector3d& x) const {
    const Eigen::Vector3d n = (at(1) - at(0)).cross(at(2) - at(0));
    return std::abs(n.dot(x - at(0))) > least() * n.norm();
  }
  // Distances below this are rounding errors.
  double least() const { return 1e-13 * size_; }

  void set_plane(Facet& of) const;
  int closest_facet() const;
  bool add_point(int from);
  bool find_horizon(const Eigen::Vector3d& eye, int start);

  const ConvexBody& A_;
  const ConvexBody& B_;
  double size_, enough_;
  std::array<Difference, most_points> points_;
  std::array<Facet, most_facets> facets_;
  std::array<HorizonEdge, most_edges> horizon_;
  std::array<int, most_facets> seen_{};
  int point_count_ = 0, facet_count_ = 0, horizon_count_ = 0, seen_count_ = 0;
};

// Adds the farthest point along one of both directions if it is off what there is.
bool Polytope::add_off(const Eigen::Vector3d& direction, bool (Polytope::*is_off)(const Eigen::Vector3d&) const) {
  constexpr std::array<double, 2> signs = {1, -1};
  return std::ranges::any_of(signs, [&](double sign) {
    const Difference found = farthest(sign * direction);
    if (!(this->*is_off)(found.w)) return false;
    points_[static_cast<std::size_t>(point_count_++)] = found;
    return true;
  });
}

// A tetrahedron that contains the given points. False if the difference of the bodies has no volume.
bool Polytope::start(const std::array<Difference, 4>& points, int count) {
  std::copy(points.begin(), points.begin() + count, points_.begin());
  point_count_ = count;
  if (count == 4 && !off_plane(at(3))) point_count_ = 3;
  if (point_count_ >= 3 && !off_line(at(2))) point_count_ = 2;
  if (point_count_ >= 2 && !off_point(at(1))) point_count_ = 1;
  for (Eigen::Index i = 0; i < 3 && point_count_ == 1; ++i) add_off(Eigen::Vector3d::Unit(i), &Polytope::off_point);
  for (Eigen::Index i = 0; i < 3 && point_count_ == 2; ++i) {
    const Eigen::Vector3d across = (at(1) - at(0)).cross(Eigen::Vector3d::Unit(i));
    if (across.norm() > 0.5 * (at(1) - at(0)).norm()) add_off(across, &Polytope::off_line);
  }
  if (point_count_ == 3) add_off((at(1) - at(0)).cross(at(2) - at(0)).normalized(), &Polytope::off_plane);
  if (point_count_ < 4) return false;
  if ((at(1) - at(0)).cross(at(2) - at(0)).dot(at(3) - at(0)) > 0) std::swap(points_[1], points_[2]);
  facets_[0] = {.vertex = {0, 1, 2}, .neighbor = {1, 2, 3}};
  facets_[1] = {.vertex = {1, 0, 3}, .neighbor = {0, 3, 2}};
  facets_[2] = {.vertex = {2, 1, 3}, .neighbor = {0, 1, 3}};
  facets_[3] = {.vertex = {0, 2, 3}, .neighbor = {0, 2, 1}};
  facet_count_ = 4;
  for (int f = 0; f < 4; ++f) set_plane(facet(f));
  return true;
}

void Polytope::set_plane(Facet& of) const {
  const Eigen::Vector3d& a = at(of.vertex[0]);
  const Eigen::Vector3d& b = at(of.vertex[1]);
  const Eigen::Vector3d& c = at(of.vertex[2]);
  const Eigen::Vector3d cross = (b - a).cross(c - a);
  const double twice_area = cross.norm();
  of.removed = false;
  of.normal = twice_area > 0 ? Eigen::Vector3d(cross / twice_area) : Eigen::Vector3d::Zero();
  // A triangle without area is beside one that has the closest point.
  of.offset = twice_area > 0 ? of.normal.dot(a + b + c) / 3 : std::numeric_limits<double>::infinity();
}

int Polytope::closest_facet() const {
  int best = -1;
  for (int f = 0; f < facet_count_; ++f) {
    const Facet& facet = facets_[static_cast<std::size_t>(f)];
    if (facet.removed) continue;
    if (best < 0 || facet.offset < facets_[static_cast<std::size_t>(best)].offset) best = f;
  }
  return best;
}

// Collects the facets that the eye sees, and the closed polygon around them; false if there is none.
bool Polytope::find_horizon(const Eigen::Vector3d& eye, int start) {
  horizon_count_ = 0;
  seen_[0] = start;
  seen_count_ = 1;
  facet(start).removed = true;
  for (int done = 0; done < seen_count_; ++done) {
    for (const int next : facet(seen_[static_cast<std::size_t>(done)]).neighbor) {
      Facet& other = facet(next);
      // Those in whose plane the eye is count as seen; see Quickhull::remove_visible().
      if (other.removed || (std::isfinite(other.offset) && other.normal.dot(eye) - other.offset <= -least())) continue;
      other.removed = true;
      seen_[static_cast<std::size_t>(seen_count_++)] = next;
    }
  }
  for (int i = 0; i < seen_count_; ++i) {
    const Facet& from = facet(seen_[static_cast<std::size_t>(i)]);
    for (std::size_t k = 0; k < 3; ++k) {
      if (facet(from.neighbor[k]).removed) continue;
      if (horizon_count_ == most_edges) return false;
      horizon_[static_cast<std::size_t>(horizon_count_++)] = {from.vertex[k], from.vertex[successor[k]],
                                                              from.neighbor[k]};
    }
  }
  if (horizon_count_ < 3) return false;
  const auto end = horizon_.begin() + horizon_count_;
  for (auto edge = horizon_.begin(); edge + 1 != end; ++edge) {
    const auto next = std::find_if(edge + 1, end, [&](const HorizonEdge& e) { return e.from == edge->to; });
    if (next == end) return false;
    std::iter_swap(edge + 1, next);
  }
  return (end - 1)->to == horizon_[0].from;
}

// Moves a facet outward; false if it is on the surface.
bool Polytope::add_point(int from) {
  const Difference next = farthest(facet(from).normal);
  const double beyond = facet(from).normal.dot(next.w) - facet(from).offset;
  if (!(beyond > enough_) || point_count_ == most_points) return false;
  if (!find_horizon(next.w, from) || facet_count_ + horizon_count_ > most_facets) {
    for (int i = 0; i < seen_count_; ++i) facet(seen_[static_cast<std::size_t>(i)]).removed = false;
    return false;
  }
  const int first = facet_count_;
  const int n = horizon_count_;
  points_[static_cast<std::size_t>(point_count_)] = next;
  for (int i = 0; i < n; ++i) {
    const HorizonEdge& edge = horizon_[static_cast<std::size_t>(i)];
    Facet& fresh = facet(facet_count_++);
    fresh.vertex = {edge.from, edge.to, point_count_};
    fresh.neighbor = {edge.beyond, first + (i + 1) % n, first + (i + n - 1) % n};
    Facet& beyond_it = facet(edge.beyond);
    for (std::size_t k = 0; k < 3; ++k)
      if (beyond_it.vertex[k] == edge.to && beyond_it.vertex[successor[k]] == edge.from)
        beyond_it.neighbor[k] = first + i;
  }
  ++point_count_;
  for (int f = first; f < facet_count_; ++f) set_plane(facet(f));
  return true;
}

void Polytope::expand() {
  while (add_point(closest_facet())) {
  }
}

ClosestPoints Polytope::closest() const {
  const Facet& facet = facets_[static_cast<std::size_t>(closest_facet())];
  ClosestPoints out;
  out.n = -facet.normal;
  out.distance = -facet.offset;
  out.count = 3;
  const Eigen::Vector3d& a = at(facet.vertex[0]);
  const Eigen::Vector3d& b = at(facet.vertex[1]);
  const Eigen::Vector3d& c = at(facet.vertex[2]);
  const double area = facet.normal.dot((b - a).cross(c - a));
  out.weights = {facet.normal.dot(b.cross(c)) / area, facet.normal.dot(c.cross(a)) / area,
                 facet.normal.dot(a.cross(b)) / area};
  // The projection of the origin is in the facet but for rounding errors.
  double sum = 0;
  for (double& weight : out.weights) sum += weight = std::max(weight, 0.0);
  for (double& weight : out.weights) weight /= sum;
  for (std::size_t i = 0; i < 3; ++i) out.by[i] = points_[static_cast<std::size_t>(facet.vertex[i])];
  return out;
}

}  // namespace

ClosestPoints penetration(const ConvexBody& A, const ConvexBody& B, const std::array<Difference, 4>& start, int count) {
  Polytope polytope(A, B);
  if (polytope.start(start, count)) {
    polytope.expand();
    return polytope.closest();
  }
  // Both cores in one plane, as of two points: they overlap without depth.
  ClosestPoints out;
  out.by[0] = start[0];
  out.weights[0] = 1;
  out.count = 1;
  return out;
}

}  // namespace gelenk
