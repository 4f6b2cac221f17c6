// SPDX-License-Identifier: BSD-3-Clause
#include "collision/simplex.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace gelenk {
namespace {

using Points = std::array<Eigen::Vector3d, 4>;

class Search {
 public:
  explicit Search(const Points& points) : p_(points) {}

  const SimplexPoint& best() const { return best_; }

  void vertex(std::size_t i) { take({{i, 0, 0, 0}}, {{1, 0, 0, 0}}, 1); }

  void edge(std::size_t i, std::size_t k) {
    const Eigen::Vector3d e = p_[k] - p_[i];
    const double length2 = e.squaredNorm();
    if (!(length2 > 0)) return;
    const double t = -e.dot(p_[i]) / length2;
    if (t > 0 && t < 1) take({{i, k, 0, 0}}, {{1 - t, t, 0, 0}}, 2);
  }

  void triangle(std::size_t i, std::size_t k, std::size_t l) {
    const Eigen::Vector3d n = (p_[k] - p_[i]).cross(p_[l] - p_[i]);
    const double area2 = n.squaredNorm();
    if (!(area2 > 0)) return;
    const double u = n.dot(p_[k].cross(p_[l])) / area2;
    const double v = n.dot(p_[l].cross(p_[i])) / area2;
    const double w = n.dot(p_[i].cross(p_[k])) / area2;
    if (!(u > 0 && v > 0 && w > 0)) return;
    const double sum = u + v + w;
    take({{i, k, l, 0}}, {{u / sum, v / sum, w / sum, 0}}, 3);
    // The projection on the plane is more accurate than the mean of the points.
    const Eigen::Vector3d foot = n * (n.dot(p_[i] + p_[k] + p_[l]) / (3 * area2));
    if (taken_) best_.p = foot;
  }

  void inside() {
    const double volume = (p_[1] - p_[0]).dot((p_[2] - p_[0]).cross(p_[3] - p_[0]));
    if (volume == 0) return;
    const double d0 = p_[1].dot(p_[2].cross(p_[3])) / volume;
    const double d1 = -p_[0].dot(p_[2].cross(p_[3])) / volume;
    const double d2 = p_[0].dot(p_[1].cross(p_[3])) / volume;
    const double d3 = -p_[0].dot(p_[1].cross(p_[2])) / volume;
    if (!(d0 > 0 && d1 > 0 && d2 > 0 && d3 > 0)) return;
    best_.p.setZero();
    best_.weights = {d0, d1, d2, d3};
    least_ = 0;
  }

 private:
  void take(const std::array<std::size_t, 4>& of, const std::array<double, 4>& weights, int n) {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    for (int i = 0; i < n; ++i) p += weights[static_cast<std::size_t>(i)] * p_[of[static_cast<std::size_t>(i)]];
    const double distance = p.squaredNorm();
    taken_ = distance < least_;
    if (!taken_) return;
    least_ = distance;
    best_.p = p;
    best_.weights = {};
    for (int i = 0; i < n; ++i) best_.weights[of[static_cast<std::size_t>(i)]] = weights[static_cast<std::size_t>(i)];
  }

  const Points& p_;
  SimplexPoint best_;
  double least_ = std::numeric_limits<double>::infinity();
  bool taken_ = false;
};

}  // namespace

// All vertices, edges and triangles are tried: no decision of one depends on rounding errors of another, as in a search
// by Voronoi regions.
SimplexPoint closest_to_origin(const Points& points, int count) {
  Search search(points);
  const auto n = static_cast<std::size_t>(count);
  for (std::size_t i = 0; i < n; ++i) search.vertex(i);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = i + 1; k < n; ++k) search.edge(i, k);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = i + 1; k < n; ++k)
      for (std::size_t l = k + 1; l < n; ++l) search.triangle(i, k, l);
  if (n == 4) search.inside();
  return search.best();
}

}  // namespace gelenk
