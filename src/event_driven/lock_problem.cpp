// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/lock_problem.h"

#include <algorithm>
#include <cmath>

#include "event_driven/decision_limits.h"
#include "linear/box_complementarity.h"
#include "math/bounds.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Relative tolerance of accelerations, less than the slack of holding forces (ForceRounding::slack).
constexpr double box_acceleration_tolerance = 1e-11;

// After a problem without a solution: a motion against a bound that constraint equations determine.
LockProblem::Unstoppable unstoppable_among(const SwitchingForces& forces, const LockProblem& problem,
                                           const BoxSolution& found, const VectorXd& scale) {
  for (std::size_t i = 0; i < problem.locks.size(); ++i) {
    const LockProblem::Lock& lock = problem.locks[i];
    const auto at = static_cast<Index>(i);
    const int side = found.r[at] > 0 ? -1 : 1;
    if (lock.contact != side) continue;
    // Rounding; and what remains in contact for a second.
    const double negligible = forces.depth(lock.lock, side).tolerance;
    if (std::abs(found.r[at]) > std::max(box_acceleration_tolerance * scale[at], negligible)) return {lock.lock, side};
  }
  return {};
}

}  // namespace

double LockProblem::Lock::lower(const DirectedLimit& friction, double part) const {
  return contact > 0 ? -unlimited : -part * friction.against(1);
}

double LockProblem::Lock::upper(const DirectedLimit& friction, double part) const {
  return contact < 0 ? unlimited : part * friction.against(-1);
}

int LockProblem::Lock::side_beyond(double least, double most) const {
  if (leaves) return 0;
  const double rounding = triggered ? 0 : slack;
  if (holding > most + rounding) return 1;
  return holding < least - rounding ? -1 : 0;
}

bool LockProblem::breaks_away() const { return std::ranges::any_of(locks, &Lock::triggered); }

void decide_on_joints(SwitchingForces& forces, const double* vdot, LockProblem& problem) {
  std::vector<int> locks;
  for (const LockProblem::Lock& lock : problem.locks) locks.push_back(lock.lock);
  Eigen::MatrixXd W;
  VectorXd scale;
  forces.compliance(locks, W, scale);
  const auto n = static_cast<Index>(locks.size());
  VectorXd b(n), limits(n), lower(n), upper(n);
  const auto limit_to = [&](Index i, const DirectedLimit& friction, double part) {
    const LockProblem::Lock& lock = problem.locks[static_cast<std::size_t>(i)];
    limits[i] = part * friction.largest();
    lower[i] = lock.lower(friction, part);
    upper[i] = lock.upper(friction, part);
  };
  const double part = problem.breaks_away() ? 1 - break_away_fraction : 1;
  for (Index i = 0; i < n; ++i) {
    b[i] = -forces.speed(locks[static_cast<std::size_t>(i)], vdot);
    limit_to(i, problem.locks[static_cast<std::size_t>(i)].sticking, part);
  }
  scale = scale.cwiseMax(W.cwiseAbs() * limits);
  // What constraint equations or latches hold needs no force for the rounding of its acceleration.
  for (Index i = 0; i < n; ++i) {
    if (W(i, i) == 0 && std::abs(b[i]) <= box_acceleration_tolerance * scale[i]) b[i] = 0;
  }
  BoxSolution found;
  const auto is_held = [&](Index i) {
    return found.at_bound[static_cast<std::size_t>(i)] == 0 ||
           std::abs(found.r[i]) <= box_acceleration_tolerance * scale[i];
  };
  for (LockProblem::Lock& lock : problem.locks) lock.leaves = false;
  for (bool changed = true; changed;) {
    changed = false;
    found = solve_in_box(W, b, lower, upper);
    for (Index i = 0; i < n; ++i) {
      LockProblem::Lock& lock = problem.locks[static_cast<std::size_t>(i)];
      if (lock.leaves || is_held(i)) continue;
      lock.leaves = true;
      if (!(limits[i] > lock.slipping.largest())) continue;
      limit_to(i, lock.slipping, 1);
      changed = true;
    }
  }
  problem.unstoppable = found.found ? LockProblem::Unstoppable{} : unstoppable_among(forces, problem, found, scale);
  for (std::size_t i = 0; i < problem.locks.size(); ++i) problem.locks[i].direction = -found.at_bound[i];
}

}  // namespace gelenk
