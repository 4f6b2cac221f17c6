// SPDX-License-Identifier: BSD-3-Clause
// What dry friction, limits and one-way clutches of joints do in steps of TimeStepper.
#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/step_limits.h"
#include "contact/time_stepper.h"

namespace gelenk {
namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

}  // namespace

void TimeStepper::add_locks(double h) {
  const Branching& branching = dynamics_.branching();
  for (int i = 0; i < branching.locks(); ++i) {
    const Branching::Lock lock = branching.lock(i);
    const double speed = branching.speed(i, v0_.data());
    if (lock.friction >= 0) {
      const bool slides = std::abs(speed) > rest_speed;
      // Without loads, it is the same in both directions.
      const double limit = h * (slides ? branching.sliding_limit(i, speed) : lock.sticking_limit.largest());
      cones_.push_back(Cone::within(rows_.count(), -limit, limit));
      rows_.add_lock(i, lock.sign);
      lock_rows_.push_back({.lock = i, .slides = slides});
    }
    if (lock.limit < 0) continue;
    for (const int side : {1, -1}) {
      const double depth = branching.depth(i, side).depth;
      // A bound that other impulses may drive the coordinate to is found in the next step.
      if (!(depth + h * (std::abs(speed) + h * std::abs(branching.speed(i, vdot_.data()))) >= -touch_tolerance))
        continue;
      cones_.push_back(side > 0 ? Cone::within(rows_.count(), -unlimited, 0)
                                : Cone::within(rows_.count(), 0, unlimited));
      rows_.add_lock(i, lock.sign);
      lock_rows_.push_back({.lock = i, .side = side, .depth = depth, .is_of_speed = lock.one_way});
    }
  }
}

// Friction of what slides, at the mean velocities vm_; returns whether it has changed.
bool TimeStepper::set_sliding_friction(double h) {
  const Branching& branching = dynamics_.branching();
  bool changed = false;
  for (std::size_t i = 0; i < lock_rows_.size(); ++i) {
    const LockRow& row = lock_rows_[i];
    if (row.side != 0 || !row.slides) continue;
    Cone& cone = cones_[points_.size() + i];
    const double limit = h * branching.sliding_limit(row.lock, branching.speed(row.lock, vm_.data()));
    changed = changed || std::abs(limit - cone.upper) > negligible_change * cone.upper;
    cone.upper = limit;
    cone.lower = -limit;
  }
  return changed;
}

// Adds to b_ what limits demand.
void TimeStepper::set_lock_velocities(double h, double part) {
  for (std::size_t i = 0; i < lock_rows_.size(); ++i) {
    const LockRow& row = lock_rows_[i];
    if (row.side == 0) continue;
    const std::size_t cone = points_.size() + i;
    const auto r = static_cast<std::size_t>(cones_[cone].first);
    if (strikes_[cone] != 0) {
      if (!is_poisson(cone)) b_[r] += row.side * part * restitution(cone) * approach(cone);
    } else if (-row.depth > touch_tolerance) {
      b_[r] += row.side * 2 * row.depth / h;
    }
  }
}

// What has stopped at a bound is in contact with it. At rest, a limit pushes, and what pulls is friction.
void TimeStepper::remember_locks(double h) {
  const Branching& branching = dynamics_.branching();
  std::ranges::fill(state_.locks, LockForces{});
  std::ranges::fill(state_.along, 0.0);
  for (std::size_t i = 0; i < lock_rows_.size(); ++i) {
    const LockRow& row = lock_rows_[i];
    const double force = x_[static_cast<std::size_t>(cones_[points_.size() + i].first)] / h;
    const double speed = branching.speed(row.lock, v1_.data());
    const bool rests = std::abs(speed) <= rest_speed;
    LockForces& at = state_.locks[static_cast<std::size_t>(row.lock)];
    if (row.side == 0) {
      at.friction = force;
      at.motion = rests ? 0 : speed > 0 ? 1 : -1;
    } else {
      at.limit += force;
      if (rests && (force != 0 || row.depth >= -touch_tolerance)) at.contact = row.side;
    }
  }
  for (std::size_t i = 0; i < state_.locks.size(); ++i) {
    LockForces& at = state_.locks[i];
    if (at.contact == 0 || branching.lock(static_cast<int>(i)).friction < 0) continue;
    const double sum = at.friction + at.limit;
    at.limit = at.contact * sum < 0 ? sum : 0;
    at.friction = sum - at.limit;
  }
  rows_.add_generalized(static_cast<int>(x_.size()) - static_cast<int>(lock_rows_.size()), x_.data(), 1 / h,
                        state_.along.data());
}

}  // namespace gelenk
