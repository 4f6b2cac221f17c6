// SPDX-License-Identifier: BSD-3-Clause
// Gaps of contacts of shapes as functions of the state, for derivatives.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

#include "contact_geometry/contact_finder.h"
#include "kinematics/readings.h"
#include "math/series.h"
#include "mechanism/mechanism.h"

namespace gelenk {

// By contact of the scene, the pair of points that are nearest to each other; gap: infinite if there is none.
class NearestPoints {
 public:
  // At the position and velocity of `dynamics`. closed: contacts of the scene of which some points are.
  void find(const Mechanism& mechanism, Dynamics& dynamics, const std::vector<bool>& closed) {
    const std::size_t contacts = closed.size();
    ContactFinder finder(mechanism, contacts);
    dynamics.readings().set_root_poses();
    const std::vector<double> gaps = finder.smallest_gaps(dynamics.readings());
    double reach = 0;
    for (const double gap : gaps) reach = std::isfinite(gap) ? std::max(reach, gap) : reach;
    nearest_.assign(contacts, {.gap = std::numeric_limits<double>::infinity()});
    for (const NearPoint& at : finder.find(dynamics.readings(), 0, 0, reach * (1 + 1e-6) + touch_tolerance)) {
      NearPoint& nearest = nearest_[static_cast<std::size_t>(at.contact)];
      if (!at.turns && at.given == 0 && at.gap < nearest.gap && !closed[static_cast<std::size_t>(at.contact)])
        nearest = at;
    }
  }
  void clear() { nearest_.clear(); }

  // The gaps of open contacts at `at`, to first order: the points move with their shapes, and the normal is that
  // between them. Of power series, higher orders depend on the curvature of the shapes and are not a number. Closed
  // gaps remain so.
  template <class T>
  std::vector<T> gaps(const Mechanism& mechanism, const Readings<T>& at) const {
    std::vector<T> out;
    for (const NearPoint& point : nearest_) {
      T& gap = out.emplace_back(0);
      if (!std::isfinite(point.gap)) continue;
      const Vector3<T> n = point.normal.template cast<T>();
      gap = n.dot(moved(mechanism, at, point.b, point.p)) - n.dot(moved(mechanism, at, point.a, point.p));
      if constexpr (std::is_same_v<T, Series>) {
        for (int k = 2; k <= series_order; ++k) gap[k] = std::numeric_limits<double>::quiet_NaN();
      }
    }
    return out;
  }

 private:
  // The point of a shape that is at p in the values of `at`.
  template <class T>
  static Vector3<T> moved(const Mechanism& mechanism, const Readings<T>& at, int shape, const Eigen::Vector3d& p) {
    const int link = mechanism.shapes[static_cast<std::size_t>(shape)].link;
    if (link == 0) return p.template cast<T>();
    const auto X = at.link_pose(link);
    Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) p_L[i] += X.R(j, i).value() * (p[j] - X.p[j].value());
    }
    return X.point(p_L.template cast<T>());
  }

  std::vector<NearPoint> nearest_;
};

}  // namespace gelenk
