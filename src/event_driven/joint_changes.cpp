// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/joint_changes.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "kinematics/force_modes.h"
#include "nonsmooth/rounding.h"

namespace gelenk {
namespace {

// Part of a limit from which on static friction is at it, with the rounding of distributed forces.
constexpr double shared_fraction = 1e-8;
// Slip that an impact causes and friction stops within this is none [natural units]: the rounding of positions, as of
// rebounds.
constexpr double shortest_slip = 2e-12;

}  // namespace

bool JointChanges::find_events_at_start(double t, const double* y) {
  if (empty()) return false;
  const double* v = y + modes_.nq_;
  modes_.dynamics_.set_position(y);
  bool evaluated = false;
  for (int i = 0; i < modes_.count(); ++i) {
    if (modes_.rests(i)) continue;
    const SwitchingForces::Lock& lock = forces_.lock(i);
    if (lock.limit >= 0) find_reached_bounds(i, v);
    if ((lock.friction < 0 && !lock.one_way) || !modes_.is_slow(i, v)) continue;
    if (!evaluated) modes_.equations_.accelerations_at(t, y, modes_.vdot_.data());
    evaluated = true;
    const double acceleration = forces_.speed(i, modes_.vdot_.data());
    LockModes::Trigger& trigger = modes_.triggered_[static_cast<std::size_t>(i)];
    if (lock.friction >= 0 && modes_.modes_.motions[i] * acceleration < 0) trigger = LockModes::by_friction;
    if (lock.one_way && modes_.touched_side(i) * acceleration > 0) trigger = LockModes::by_limit;
  }
  modes_.dynamics_.set_position(y);
  forget_rebounds(y);
  return is_triggered();
}

// Of a coordinate with limits, at the position of `dynamics` and the velocities v.
void JointChanges::find_reached_bounds(int lock, const double* v) {
  bool away = true;
  double& leaves_from = modes_.modes_.leaves_from[static_cast<std::size_t>(lock)];
  for (const int side : {1, -1}) {
    const SwitchingForces::Depth at = forces_.depth(lock, side);
    const bool is_near = at.depth >= -reached_fraction * at.tolerance;
    away = away && !is_near;
    const bool reached = leaves_from == 0 && is_near;
    if (reached && side * forces_.speed(lock, v) > 0 && !modes_.is_slow(lock, v))
      modes_.triggered_[static_cast<std::size_t>(lock)] = LockModes::by_limit;
  }
  if (away) leaves_from = 0;
}

bool JointChanges::is_triggered() const {
  return std::ranges::any_of(modes_.triggered_, [](auto trigger) { return trigger != LockModes::nothing; });
}

bool JointChanges::breaks_away() const {
  for (int i = 0; i < modes_.count(); ++i) {
    if (modes_.triggered_[static_cast<std::size_t>(i)] != LockModes::nothing && modes_.rests(i)) return true;
  }
  return false;
}

std::size_t JointChanges::find_yielding(double* g, std::vector<double*>& out) const {
  std::size_t resting = 0;
  for (int i = 0; i < modes_.count(); ++i) {
    if (!modes_.rests(i) || modes_.is_latched(i)) continue;
    ++resting;
    const SwitchingForces::Lock& lock = forces_.lock(i);
    for (const int force : {lock.friction, lock.limit}) {
      if (force < 0) continue;
      for (const int side : {1, -1}) {
        double& value = g[2 * force + (side > 0 ? 0 : 1)];
        if ((value > 0) != (modes_.sides_[static_cast<std::size_t>(force)] == side)) out.push_back(&value);
      }
    }
  }
  return resting;
}

void JointChanges::begin_run(bool keeps_latches) {
  modes_.release(keeps_latches);
  modes_.modes_.unstoppable = -1;
}

// Whether friction could have kept a coordinate at rest in a step of this length, at the end of which it moves with
// these velocities: a motion known by its values alone has changed its speed within the step, not at its end.
bool JointChanges::could_be_held(int lock, const double* v, double span) {
  if (!modes_.has_friction(lock) || !(span > 0)) return false;
  Eigen::MatrixXd W;
  Eigen::VectorXd scale;
  forces_.compliance({lock}, W, scale);
  const double speed = forces_.speed(lock, v);
  return std::abs(speed) <= span * W(0, 0) * forces_.sticking_limit(lock).against(speed > 0 ? 1 : -1);
}

void JointChanges::stop_unmoved(const double* y, const LockModes::State& before, double estimated_over) {
  const double* v = y + modes_.nq_;
  for (int i = 0; i < modes_.count(); ++i) {
    if (before.rests(i) && (modes_.is_unmoved(i, v) || could_be_held(i, v, estimated_over)))
      modes_.triggered_[static_cast<std::size_t>(i)] = LockModes::by_friction;
  }
}

void JointChanges::forget_rebounds(const double* y) {
  const double* v = y + modes_.nq_;
  for (int i = 0; i < modes_.count(); ++i) {
    if (modes_.triggered_[static_cast<std::size_t>(i)] != LockModes::by_limit) continue;
    const bool rebounds = !forces_.lock(i).one_way && modes_.modes_.contacts[i] == 0 && !modes_.is_slow(i, v) &&
                          modes_.touched_side(i) * forces_.speed(i, v) < 0;
    if (!rebounds) continue;
    modes_.triggered_[static_cast<std::size_t>(i)] = LockModes::nothing;
    modes_.modes_.leaves_from[static_cast<std::size_t>(i)] = modes_.leaving_depth_of(i);
  }
}

void JointChanges::force_away() {
  LockModes::State next = state();
  for (int i = 0; i < modes_.count(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (!modes_.rests(i) || modes_.is_latched(i)) continue;
    if (modes_.triggered_[at] == LockModes::nothing && !uses_limit_up(i)) continue;
    next.motions[at] = next.contacts[at] != 0 ? -next.contacts[at] : modes_.holding_[at] > 0 ? -1 : 1;
    next.contacts[at] = 0;
    next.leaves_from[at] = modes_.leaving_depth_of(i);
    if (!modes_.has_friction(i)) next.motions[at] = mode_released;
  }
  modes_.enter(std::move(next), Recording::doubts);
}

// Whether friction at rest is at its limit, within what distributed forces are in error.
bool JointChanges::uses_limit_up(int lock) const {
  const double holding = modes_.holding_[static_cast<std::size_t>(lock)];
  const double limit = forces_.sticking_limit(lock).against(holding > 0 ? -1 : 1);
  return modes_.modes_.contacts[static_cast<std::size_t>(lock)] == 0 && limit > 0 &&
         std::abs(holding) >= (1 - shared_fraction) * limit;
}

int JointChanges::first_to_stop(const double* y) const {
  for (int i = 0; i < modes_.count(); ++i) {
    if (modes_.has_wrong_speed(i, y + modes_.nq_)) return i;
  }
  return -1;
}

std::string JointChanges::text_of_stop(int lock) const {
  const SwitchingForces::Lock& of = forces_.lock(lock);
  if (modes_.modes_.latched[lock] != 0) return modes_.log_.report({0, 2 * of.latch, true}).text;
  const bool is_friction = of.friction >= 0;
  return modes_.log_.report({0, 2 * (is_friction ? of.friction : of.limit), !is_friction}).text;
}

void JointChanges::finish(double* y) {
  if (empty()) return;
  if (modes_.any_at_rest_ || any_wrong_speed(y)) stop(y);
}

int JointChanges::stop_friction(int force) {
  const int lock = modes_.lock_of_[static_cast<std::size_t>(force)];
  modes_.triggered_[static_cast<std::size_t>(lock)] = LockModes::by_friction;
  return lock;
}

// Whether a coordinate that something has set in motion at this instant comes to rest again before the motion matters,
// with the last accelerations: one that has left a bound that it touches still, and returns to it; one that friction
// stops. Of what rebounds by its own restitution, only rounding does not matter, so that the end of a series of impacts
// does not depend on tolerances.
bool JointChanges::returns(int lock, const LockModes::State& before, const double* v) const {
  if (modes_.is_slow(lock, v)) return false;
  const double* vdot = modes_.vdot_.data();
  const double speed = forces_.speed(lock, v);
  const SwitchingForces::Lock& of = forces_.lock(lock);
  const LockModes::State& present = modes_.modes_;
  const int side = present.contacts[lock] == 0 && present.leaves_from[lock] != 0 ? modes_.touched_side(lock) : 0;
  if (side != 0) {
    const bool rebounds = forces_.depth(lock, side).restitution > 0 && before.contacts[lock] == 0;
    const double resolution = rebounds ? 0 : modes_.resolution();
    if (modes_.returns_to(lock, side, resolution, speed, side * forces_.speed(lock, vdot))) return true;
  }
  if (of.friction < 0 || !before.rests(lock) || modes_.rests(lock)) return false;
  const double deceleration = (speed > 0 ? -1 : 1) * forces_.speed(lock, vdot);
  return deceleration > 0 && speed * speed <= 2 * deceleration * std::max(modes_.resolution(), shortest_slip);
}

std::vector<int> JointChanges::find_returning(double t, const double* y, const LockModes::State& before,
                                              std::vector<int>& stopped) {
  const double* v = y + modes_.nq_;
  std::vector<int> out;
  if (empty()) return out;
  modes_.dynamics_.set_position(y);
  const LockModes::State& present = modes_.modes_;
  for (int i = 0; i < modes_.count(); ++i) {
    const bool left = present.leaves_from[i] != 0 && present.contacts[i] == 0 && modes_.touched_side(i) != 0;
    const bool slips = modes_.has_friction(i) && !modes_.rests(i) && before.rests(i);
    if (left || slips) out.push_back(i);
  }
  if (out.empty()) return out;
  modes_.equations_.accelerations_at(t, y, modes_.vdot_.data());
  std::erase_if(out, [&](int i) { return !returns(i, before, v); });
  if (out.empty()) return out;
  for (const int lock : out) {
    if (modes_.touched_side(lock) != 0) modes_.triggered_[static_cast<std::size_t>(lock)] = LockModes::by_limit;
  }
  std::erase_if(stopped, [&](int lock) { return !modes_.rests(lock); });
  out.insert(out.end(), stopped.begin(), stopped.end());
  std::ranges::sort(out);
  stopped.clear();
  std::ranges::copy_if(out, std::back_inserter(stopped), [&](int lock) { return modes_.has_friction(lock); });
  return out;
}

bool JointChanges::have_turned(const double* y) {
  const double* v = y + modes_.nq_;
  bool out = false;
  for (int i = 0; i < modes_.count(); ++i) {
    const int motion = modes_.modes_.motions[i];
    if (!modes_.has_friction(i) || motion == mode_released) continue;
    if (motion * forces_.speed(i, v) >= 0 || modes_.is_slow(i, v)) continue;
    modes_.triggered_[static_cast<std::size_t>(i)] = LockModes::nothing;
    out = true;
  }
  return out;
}

void JointChanges::record_changes(double t, const LockModes::State& before) {
  for (int i = 0; i < modes_.count(); ++i) {
    const SwitchingForces::Lock& lock = forces_.lock(i);
    const int motion = modes_.modes_.motions[i], contact = modes_.modes_.contacts[i];
    if (lock.is_first_of_latch && modes_.modes_.latched[i] != before.latched[i])
      modes_.log_.add({t, 2 * lock.latch, modes_.modes_.latched[i] != 0});
    if (lock.friction >= 0 && motion != before.motions[i]) {
      const int direction = motion != 0 ? motion : before.motions[i];
      modes_.log_.add({t, 2 * lock.friction + (direction < 0 ? 1 : 0), motion != 0});
    }
    if (before.contacts[i] != 0 && contact == 0)
      modes_.log_.add({t, modes_.limit_indicator(i, before.contacts[i]), false});
    if (lock.one_way && before.contacts[i] == 0 && contact != 0)
      modes_.log_.add({t, modes_.limit_indicator(i, contact), true});
  }
}

}  // namespace gelenk
