// SPDX-License-Identifier: BSD-3-Clause
// What dry friction, limits and one-way clutches of joints do in steps of TimeStepper.
#include <algorithm>
#include <cmath>

#include "contact/step_limits.h"
#include "contact/time_stepper.h"
#include "math/bounds.h"

namespace gelenk {
namespace {

// Part of the static friction from which on it is all of it, as the solver leaves it.
constexpr double at_bound = 1 - 1e-6;
// Speed that a projection may give, relative to that which a step without friction would: of the third order in the
// step, 2e-6 where a prescribed motion of 1.5 Hz is followed in steps of 1 ms.
constexpr double negligible_part = 3e-5;

}  // namespace

void TimeStepper::add_locks(double h) {
  const Branching& branching = dynamics_.branching();
  for (int i = 0; i < branching.locks(); ++i) {
    const Branching::Lock lock = branching.lock(i);
    const double speed = branching.speed(i, v0_.data());
    if (lock.friction >= 0) {
      // What friction has held is at rest, but for the speed that a projection may have given it. Where an input jumps,
      // it is no longer.
      const LockForces& last = state_.locks[static_cast<std::size_t>(i)];
      const bool was_held = last.motion == 0 && last.friction != 0 &&
                            std::abs(speed) <= negligible_part * h * std::abs(branching.speed(i, vdot_.data()));
      const bool slides = !was_held && std::abs(speed) > rest_speed;
      LockRow row{.lock = i, .slides = slides ? (speed > 0 ? 1 : -1) : 0};
      // Without loads, it is the same in both directions.
      row.at_rest = h * lock.sticking_limit.largest();
      cones_.push_back(Cone::within(rows_.count(), 0, 0));
      set_friction_of(row, slides ? h * branching.sliding_limit(i, speed) : row.at_rest, cones_.back());
      rows_.add_lock(i, lock.sign);
      lock_rows_.push_back(row);
    }
    if (lock.limit < 0) continue;
    for (const int side : {1, -1}) {
      const double depth = branching.depth(i, side).depth;
      // A bound that other impulses may drive the coordinate to is struck in the next step.
      if (!(depth + h * (std::abs(speed) + h * std::abs(branching.speed(i, vdot_.data()))) >= -touch_tolerance))
        continue;
      cones_.push_back(side > 0 ? Cone::within(rows_.count(), -unlimited, 0)
                                : Cone::within(rows_.count(), 0, unlimited));
      rows_.add_lock(i, lock.sign);
      lock_rows_.push_back({.lock = i, .side = side, .depth = depth, .is_of_speed = lock.one_way});
    }
  }
}

// What slides comes to rest before it turns back, and is then held by up to the static friction.
void TimeStepper::set_friction_of(const LockRow& row, double sliding, Cone& cone) {
  cone.lower = row.slides < 0 && !row.turns_back ? -row.at_rest : -sliding;
  cone.upper = row.slides > 0 && !row.turns_back ? row.at_rest : sliding;
}

// Friction of what slides, at the mean velocities vm_, of the last solution; returns whether it has changed.
bool TimeStepper::set_sliding_friction(double h) {
  const Branching& branching = dynamics_.branching();
  bool changed = false;
  for (std::size_t i = 0; i < lock_rows_.size(); ++i) {
    LockRow& row = lock_rows_[i];
    if (row.side != 0 || row.slides == 0) continue;
    Cone& cone = cones_[points_.size() + i];
    const double held = row.slides * x_[static_cast<std::size_t>(cone.first)];
    row.turns_back = row.turns_back || (row.slides * branching.speed(row.lock, v1_.data()) < -rest_speed &&
                                        held >= at_bound * row.at_rest);
    const Cone before = cone;
    set_friction_of(row, h * branching.sliding_limit(row.lock, branching.speed(row.lock, vm_.data())), cone);
    changed = changed || std::abs(cone.upper - before.upper) > negligible_change * before.upper ||
              std::abs(cone.lower - before.lower) > negligible_change * -before.lower;
  }
  return changed;
}

// Adds rows, without impulses, of limits that the velocities at the end of the step, v1_, lead beyond, although those
// at its start did not reach them, as where an impact drives a joint to its limit: the position ends at the limit, with
// the speed with which the next step strikes it.
void TimeStepper::add_passed_limits(double h) {
  const Branching& branching = dynamics_.branching();
  const std::size_t before = cones_.size();
  for (int i = 0; i < branching.locks(); ++i) {
    const Branching::Lock lock = branching.lock(i);
    if (lock.limit < 0 || lock.one_way) continue;
    const double speed = branching.speed(i, v1_.data());
    const int side = speed > 0 ? 1 : -1;
    const double depth = branching.depth(i, side).depth;
    const auto is_row = [&](const LockRow& row) { return row.lock == i && row.side == side; };
    if (!(depth + h / 2 * std::abs(speed) > touch_tolerance) || std::ranges::any_of(lock_rows_, is_row)) continue;
    cones_.push_back(Cone::within(rows_.count(), 0, 0));
    rows_.add_lock(i, lock.sign);
    lock_rows_.push_back({.lock = i, .side = side, .depth = depth});
  }
  if (cones_.size() > before) extend_rows();
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
