// SPDX-License-Identifier: BSD-3-Clause
#include "collision/contact_set.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace gelenk {
namespace {

// A point replaces another one only if it is better by this fraction, so that among equivalent points rounding errors
// do not decide, which would change from step to step.
constexpr double distinct = 1e-6;

}  // namespace

void ContactSet::add(const ContactPoint& point) {
  if (!(point.gap <= margin_)) return;
  least_gap_ = std::min(least_gap_, point.gap);
  if (count_ == capacity) reduce();
  points_[static_cast<std::size_t>(count_++)] = point;
}

// Index of the point with the largest positive measure, -1 if there is none; of equivalent ones the deepest, then the
// first.
template <class Measure>
int ContactSet::best_by(double scale, const std::array<int, max_contact_points>& chosen, int n,
                        const Measure& measure) const {
  int best = -1;
  double most = distinct * scale;
  for (int i = 0; i < count_; ++i) {
    if (std::find(chosen.begin(), chosen.begin() + n, i) != chosen.begin() + n) continue;
    const auto& point = points_[static_cast<std::size_t>(i)];
    const double value = measure(point.p);
    const bool deeper =
        best >= 0 && point.gap < points_[static_cast<std::size_t>(best)].gap - distinct * std::abs(margin_);
    if (value > most + distinct * scale || (best >= 0 && value > most - distinct * scale && deeper)) {
      most = value;
      best = i;
    }
  }
  return best;
}

void ContactSet::reduce() {
  const auto begin = points_.begin();
  std::sort(begin, begin + count_, [](const ContactPoint& a, const ContactPoint& b) { return a.feature < b.feature; });
  if (count_ <= max_contact_points) return;
  Eigen::Vector3d lower = points_[0].p;
  Eigen::Vector3d upper = lower;
  for (int i = 1; i < count_; ++i) {
    lower = lower.cwiseMin(points_[static_cast<std::size_t>(i)].p);
    upper = upper.cwiseMax(points_[static_cast<std::size_t>(i)].p);
  }
  const double extent = (upper - lower).norm();
  std::array<int, max_contact_points> chosen{};
  for (int i = 1; i < count_; ++i) {
    const double gap = points_[static_cast<std::size_t>(i)].gap;
    if (gap < points_[static_cast<std::size_t>(chosen[0])].gap - distinct * extent) chosen[0] = i;
  }
  int n = 1;
  const auto at = [&](int k) -> const Eigen::Vector3d& {
    return points_[static_cast<std::size_t>(chosen[static_cast<std::size_t>(k)])].p;
  };
  const Eigen::Vector3d normal = points_[static_cast<std::size_t>(chosen[0])].normal;
  const auto area = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    return normal.dot((b - a).cross(c - a));
  };
  const auto take = [&](int found) {
    if (found >= 0) chosen[static_cast<std::size_t>(n++)] = found;
    return found >= 0;
  };
  const auto distance = [&](const Eigen::Vector3d& x) { return normal.cross(x - at(0)).norm(); };
  const auto off_line = [&](const Eigen::Vector3d& x) { return std::abs(area(at(0), at(1), x)); };
  const auto off_triangle = [&](const Eigen::Vector3d& x) {
    const double sign = area(at(0), at(1), at(2)) < 0 ? -1 : 1;
    double most = 0;
    for (int k = 0; k < 3; ++k) most = std::max(most, -sign * area(at(k), at((k + 1) % 3), x));
    return most;
  };
  if (take(best_by(extent, chosen, n, distance)) && take(best_by(extent * extent, chosen, n, off_line)))
    take(best_by(extent * extent, chosen, n, off_triangle));
  std::sort(chosen.begin(), chosen.begin() + n);
  for (int k = 0; k < n; ++k)
    points_[static_cast<std::size_t>(k)] = points_[static_cast<std::size_t>(chosen[static_cast<std::size_t>(k)])];
  count_ = n;
}

int ContactSet::write(const Eigen::Vector3d& origin, bool reversed, ContactPoint* out) {
  reduce();
  for (int i = 0; i < count_; ++i) {
    out[i] = points_[static_cast<std::size_t>(i)];
    out[i].p += origin;
    if (reversed) out[i].normal = -out[i].normal;
  }
  return count_;
}

}  // namespace gelenk
