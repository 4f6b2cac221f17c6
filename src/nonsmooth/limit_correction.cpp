// SPDX-License-Identifier: BSD-3-Clause
#include "nonsmooth/limit_correction.h"

#include <algorithm>
#include <cmath>

#include "linear/box_complementarity.h"
#include "math/bounds.h"
#include "nonsmooth/rounding.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Speeds towards a limit of less than this, relative to the largest or 1, are rounding, and no impact follows.
constexpr double rest_fraction = 1e-12;

}  // namespace

LimitCorrection::LimitCorrection(SwitchingForces& forces) : forces_(forces) {
  for (int i = 0; i < forces.locks(); ++i) {
    if (forces.lock(i).limit >= 0 && !forces.lock(i).one_way) limits_.push_back({.lock = i});
  }
}

void LimitCorrection::begin(const double* v) {
  for (Limit& limit : limits_) {
    for (const int side : {-1, 1}) {
      const SwitchingForces::Depth at = forces_.depth(limit.lock, side);
      limit.approaches[side > 0 ? 1 : 0] = at.depth >= -at.tolerance && side * forces_.speed(limit.lock, v) > 0;
    }
  }
}

// sides: to which each coordinate must not move by more than -beyond. Adds to `change` what limits do, which push only.
bool LimitCorrection::strike(const std::vector<int>& locks, const std::vector<int>& sides,
                             const std::vector<double>& beyond, std::span<double> change) {
  Eigen::MatrixXd W;
  VectorXd scale;
  forces_.compliance(locks, W, scale);
  const auto n = static_cast<Index>(locks.size());
  VectorXd b(n), lower(n), upper(n);
  for (Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    b[i] = -sides[k] * beyond[k];
    lower[i] = sides[k] > 0 ? -unlimited : 0;
    upper[i] = sides[k] > 0 ? 0 : unlimited;
  }
  const BoxSolution found = solve_in_box(W, b, lower, upper);
  if (!found.x.allFinite()) return false;
  forces_.strike(locks, found.x, change.data());
  return true;
}

bool LimitCorrection::correct_position(std::span<double> dv) {
  std::vector<int> locks, sides;
  std::vector<double> beyond;
  bool any = false;
  for (const Limit& limit : limits_) {
    const SwitchingForces::Depth upper = forces_.depth(limit.lock, 1);
    const SwitchingForces::Depth lower = forces_.depth(limit.lock, -1);
    const SwitchingForces::Depth& nearer = upper.depth > lower.depth ? upper : lower;
    if (!std::isfinite(nearer.depth)) continue;
    any = any || nearer.depth > nearer.tolerance;
    locks.push_back(limit.lock);
    sides.push_back(upper.depth > lower.depth ? 1 : -1);
    beyond.push_back(nearer.depth);
  }
  std::ranges::fill(dv, 0.0);
  return any && strike(locks, sides, beyond, dv);
}

void LimitCorrection::correct_velocity(std::span<double> v) {
  std::vector<int> locks, sides;
  std::vector<double> beyond;
  bool any = false;
  const double rest = rest_fraction * fastest_of(v);
  for (const Limit& limit : limits_) {
    for (const int side : {-1, 1}) {
      const SwitchingForces::Depth at = forces_.depth(limit.lock, side);
      if (!(at.depth >= -at.tolerance) || limit.approaches[side > 0 ? 1 : 0]) continue;
      const double speed = side * forces_.speed(limit.lock, v.data());
      any = any || speed > rest;
      locks.push_back(limit.lock);
      sides.push_back(side);
      beyond.push_back(speed);
      break;
    }
  }
  if (any) strike(locks, sides, beyond, v);
}

}  // namespace gelenk
