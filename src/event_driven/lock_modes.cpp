// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/lock_modes.h"

#include <algorithm>
#include <cmath>

#include "dynamics/distributed_forces.h"
#include "kinematics/force_modes.h"
#include "nonsmooth/rounding.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Speeds up to this fraction of the largest, or of 1, are rest: the rounding of a speed that changes its sign.
constexpr double rest_tolerance = 1e-12;
// After an impact of a prescribed motion that jumps, speeds up to this are rest, in units of the fastest: more than
// what closing the loops again leaves in joints that the impact does not move. And this multiple of the tolerance of
// the integration, to which its errors add up: the derivatives of a position that a master sends are rounded and end
// with some order, and so small a jump must not end the hold of static friction.
constexpr double unmoved_tolerance = 1e-10;
constexpr double unmoved_multiple = 10;
// Limits that depend on loads depend on how the holding forces are distributed, which depends on the limits.
constexpr int most_distributions = 60;
constexpr double distribution_tolerance = 1e-13;  // change of the forces, relative to the largest
// Part of the tolerance of the integration that a motion may take that is left out.
constexpr double resolved_fraction = 1e-3;

}  // namespace

LockModes::LockModes(ModeEquations& equations, Dynamics& dynamics, int nq, int nv, EventLog& log,
                     std::vector<int>& sides)
    : equations_(equations),
      dynamics_(dynamics),
      forces_(dynamics.switching_forces()),
      nq_(nq),
      nv_(nv),
      log_(log),
      sides_(sides),
      lock_of_(sides.size(), -1),
      modes_{std::vector<int>(static_cast<std::size_t>(forces_.locks())),
             std::vector<int>(static_cast<std::size_t>(forces_.locks())),
             std::vector<int>(static_cast<std::size_t>(forces_.locks())),
             std::vector<double>(static_cast<std::size_t>(forces_.locks()))},
      triggered_(modes_.motions.size()),
      holding_(modes_.motions.size()),
      indicators_(2 * sides.size()),
      indicator_rates_(indicators_.size()),
      vdot_(static_cast<std::size_t>(nv)) {
  resting_.reserve(modes_.motions.size());
  kept_ = modes_;
  for (int i = 0; i < count(); ++i) {
    const SwitchingForces::Lock& lock = forces_.lock(i);
    any_friction_ = any_friction_ || lock.friction >= 0 || lock.one_way;
    for (const int law : forces_.lock(i).frictions) lock_of_[static_cast<std::size_t>(law)] = i;
    if (lock.limit >= 0) lock_of_[static_cast<std::size_t>(lock.limit)] = i;
    if (lock.latch < 0) continue;
    lock_of_[static_cast<std::size_t>(lock.latch)] = i;
    any_latch_ = true;
  }
  owns_all_ = std::ranges::none_of(lock_of_, [](int lock) { return lock < 0; });
  if (!empty()) release();
}

double LockModes::resolution() const { return resolved_fraction * tolerance_; }

bool LockModes::is_slow(int lock, const double* v) const { return is_slow(lock, v, rest_tolerance); }
bool LockModes::is_slow(int lock, const double* v, double tolerance) const {
  return std::abs(forces_.speed(lock, v)) <= tolerance * fastest_of({v, static_cast<std::size_t>(nv_)});
}

bool LockModes::keeps_mode(int force, const double* v) const {
  if (!owns(force)) return false;
  const int lock = lock_of_[static_cast<std::size_t>(force)];
  const SwitchingForces::Lock& of = forces_.lock(lock);
  if (rests(lock) || of.latch == force) return true;
  return (of.limit != force || of.one_way) && is_slow(lock, v);
}

// The side on which the coordinate is in contact or touches a bound at the position of `dynamics`; otherwise 0.
int LockModes::touched_side(int lock) const {
  if (is_latched(lock)) return 0;
  if (modes_.contacts[lock] != 0) return modes_.contacts[lock];
  for (const int side : {1, -1}) {
    const SwitchingForces::Depth at = forces_.depth(lock, side);
    if (at.depth >= -at.tolerance) return side;
  }
  return 0;
}

const double* LockModes::accelerations(double t, const double* y) {
  dynamics_.set_position(y);
  dynamics_.set_velocity(y + nq_);
  const bool needs_all = (!owns_all_ && forces_.needs_accelerations()) || dynamics_.kinks().need_accelerations();
  const bool may_stop = any_friction_ && (equations_.bring_inputs(t, y) || any_can_stick(forces_));
  if (!any_at_rest_ && !needs_all && !may_stop) {
    if (any_latch_) equations_.bring_inputs(t, y);
    return nullptr;
  }
  find_holding_forces(t, y);
  if (needs_all) dynamics_.set_acceleration(vdot_.data());  // of cut joints, too
  return vdot_.data();
}

// Brings the holding forces to (t, y).
void LockModes::find_holding_forces(double t, const double* y) {
  equations_.accelerations_at(t, y, vdot_.data());
  distribute_holding_forces();
}

const std::vector<double>& LockModes::distribute_holding_forces() {
  const bool may_change = !forces_.loads().empty();
  if (may_change || distributed_at_ != dynamics_.solution()) distribute(holding_);
  distributed_at_ = dynamics_.solution();
  return holding_;
}

// holding: out, see distribute_holding_forces().
void LockModes::distribute(std::vector<double>& holding) {
  holding = forces_.holding_forces().values();
  if (!any_at_rest_ || !forces_.is_redundant()) return;
  std::vector<int>& locks = resting_;
  locks.clear();
  for (int i = 0; i < count(); ++i) {
    if (rests(i)) locks.push_back(i);
  }
  double change = INFINITY;
  for (int round = 0; round < most_distributions && change > distribution_tolerance; ++round) {
    const VectorXd& x = distributed_.find(forces_, locks, modes_.contacts);
    double largest = 0;
    change = 0;
    for (Index i = 0; i < x.size(); ++i) {
      double& of = holding[static_cast<std::size_t>(locks[i])];
      change = std::max(change, std::abs(x[i] - of));
      largest = std::max(largest, std::abs(x[i]));
      of = x[i];
    }
    if (forces_.loads().empty()) break;
    change = largest > 0 ? change / largest : 0;
    forces_.distribute_loads(holding);
  }
}

bool LockModes::exceed(const std::vector<double>& holding) const {
  for (int i = 0; i < count(); ++i) {
    if (!rests(i) || is_latched(i)) continue;
    const DirectedLimit limit = forces_.sticking_limit(i);
    const double slack = forces_.slack(i);
    if ((holding[i] > limit.against(-1) + slack && modes_.contacts[i] >= 0) ||
        (holding[i] < -limit.against(1) - slack && modes_.contacts[i] <= 0))
      return true;
  }
  return false;
}

// Of the speed of its coordinate, by velocity.
VectorXd LockModes::row(int lock) const {
  VectorXd unit = VectorXd::Zero(nv_);
  VectorXd out(nv_);
  for (Index k = 0; k < nv_; ++k) {
    unit[k] = 1;
    out[k] = forces_.speed(lock, unit.data());
    unit[k] = 0;
  }
  return out;
}

double LockModes::leaving_depth_of(int lock) const {
  const int side = touched_side(lock);
  if (side == 0 || forces_.lock(lock).one_way) return 0;
  const SwitchingForces::Depth at = forces_.depth(lock, side);
  return leaving_depth(at.depth, at.tolerance);
}

// Whether a rebound from a bound at this speed, with this acceleration back, would be lost in rounding, or not be
// higher than the resolution, and more would follow.
bool LockModes::returns_to(int lock, int side, double resolution, double speed, double back) const {
  if (forces_.lock(lock).one_way) return false;
  const double height = std::max(resolution, lowest_rebound * forces_.depth(lock, side).tolerance);
  return rises_no_higher(height, speed, back);
}

void LockModes::keep_indicators(const double* g, const double* gdot) {
  indicated_at_ = dynamics_.solution();
  std::copy_n(g, indicators_.size(), indicators_.begin());
  std::copy_n(gdot, indicator_rates_.size(), indicator_rates_.begin());
}

void LockModes::indicators(const double* vdot, double* g, double* gdot) {
  // A mechanism that is held is asked where a step begins and where it ends, in the same state.
  if (vdot == nullptr || indicated_at_ != dynamics_.solution() || !forces_.loads().empty()) {
    forces_.indicators(holding_, vdot, g, gdot);
    if (vdot != nullptr) keep_indicators(g, gdot);
  } else {
    std::ranges::copy(indicators_, g);
    std::ranges::copy(indicator_rates_, gdot);
  }
  for (int i = 0; i < count(); ++i) {
    if (modes_.leaves_from[i] == 0 || modes_.contacts[i] != 0) continue;
    for (const int side : {0, 1}) g[2 * forces_.lock(i).limit + side] -= modes_.leaves_from[i];
  }
}

// Whether the modes have to be determined again. jumped: inputs may have jumped since they were.
bool LockModes::is_doubtful(double t, const double* y, bool jumped) {
  const double* v = y + nq_;
  bool doubtful = false;
  for (int i = 0; i < count() && !doubtful; ++i) {
    // What a prescribed motion moves cannot be held; what is about to move may be kept from it by other inputs.
    doubtful = rests(i) ? !is_slow(i, v) : jumped && is_slow(i, v);
  }
  if (!doubtful && jumped && any_at_rest_) {
    find_holding_forces(t, y);
    doubtful = exceed(holding_);
    // What other constraints determine needs no force to be at rest: whether it begins to move, they say.
    for (int i = 0; i < count() && !doubtful; ++i)
      doubtful = rests(i) && !is_latched(i) && std::isinf(forces_.slack(i));
  }
  return doubtful;
}

// Writes the modes where the equations read them.
void LockModes::hold() {
  any_at_rest_ = false;
  all_at_rest_ = owns_all_;
  distributed_at_ = indicated_at_ = -1;
  for (int i = 0; i < count(); ++i) {
    for (const int law : forces_.lock(i).frictions) sides_[static_cast<std::size_t>(law)] = modes_.motions[i];
    const int limit = forces_.lock(i).limit;
    if (limit >= 0) sides_[static_cast<std::size_t>(limit)] = modes_.contacts[i];
    if (const int latch = forces_.lock(i).latch; latch >= 0) sides_[at_index(latch)] = modes_.latched[i];
    any_at_rest_ = any_at_rest_ || rests(i);
    all_at_rest_ = all_at_rest_ && rests(i);
  }
  forces_.hold(sides_.data());
}

void LockModes::release(bool keeps_latches) {
  if (!keeps_latches) std::ranges::fill(modes_.latched, 0);
  std::ranges::fill(modes_.motions, mode_released);
  std::ranges::fill(modes_.contacts, 0);
  std::ranges::fill(modes_.leaves_from, 0);
  hold();
}

void LockModes::set_state(const State& state) {
  modes_ = state;
  hold();
}

void LockModes::return_to_state() {
  if (modes_ != kept_) set_state(kept_);
}

bool LockModes::found_event(int indicator) {
  if (!owns(indicator / 2)) return false;
  const int lock = lock_of_[static_cast<std::size_t>(indicator / 2)];
  triggered_[lock] = forces_.lock(lock).latch == indicator / 2 ? by_latch
                     : is_of_limit(indicator)                  ? by_limit
                                                               : by_friction;
  return true;
}

// Whether nothing but rounding, or a jump of a prescribed motion within the error of its derivatives, has moved it.
bool LockModes::is_unmoved(int lock, const double* v) const {
  return is_slow(lock, v, std::max(unmoved_tolerance, unmoved_multiple * tolerance_));
}

// Whether by rounding the coordinate rests at a speed that is not zero, or begins to move at one of the other sign. The
// direction of what an event has let go follows from its acceleration: with a speed of the other sign it would be let
// go in the same direction again and again, in steps as short as rounding.
bool LockModes::has_wrong_speed(int lock, const double* v) const {
  const double speed = forces_.speed(lock, v);
  if (rests(lock)) return speed != 0;
  if (forces_.lock(lock).one_way && touched_side(lock) * speed > 0) return is_slow(lock, v);
  if (!has_friction(lock) || modes_.motions[lock] * speed >= 0) return false;
  return is_slow(lock, v) || triggered_[at_index(lock)] == by_friction;
}

bool LockModes::any_wrong_speed(const double* v) const {
  for (int i = 0; i < count(); ++i) {
    if (has_wrong_speed(i, v)) return true;
  }
  return false;
}

// Stops what rests and what has a wrong speed, and removes what impacts have left in the constraint equations. A wrong
// speed remains where its coordinate hardly determines the motion, as at a dead center.
void LockModes::stop(double* v) {
  const State modes = state();
  State stopped = modes;
  for (int i = 0; i < count(); ++i) {
    if (rests(i) || !has_wrong_speed(i, v)) continue;
    if (has_friction(i)) stopped.motions[i] = 0;
    if (forces_.lock(i).one_way) stopped.contacts[i] = touched_side(i);
  }
  set_state(stopped);
  if (!forces_.stop(v)) {
    set_state(modes);
    forces_.stop(v);
    forces_.clear(v);
  }
  dynamics_.set_velocity(v);
  dynamics_.min_norm_displacement(dynamics_.row_rates().data(), vdot_.data());
  for (int k = 0; k < nv_; ++k) v[k] += vdot_[k];
  set_state(modes);
}

void LockModes::enter(State next, Recording records) {
  const State before = state();
  const bool changed = next != before;
  for (int i = 0; i < count(); ++i) {
    double& from = next.leaves_from[i];
    if (next.contacts[i] != 0) {
      from = 0;
    } else if (before.contacts[i] != 0 && from == 0) {
      from = leaving_depth_of(i);  // an impact elsewhere has thrown it off
    }
  }
  set_state(next);
  if (changed && records != Recording::nothing) equations_.mode_changed();
}

void LockModes::serialize(Archive& archive) {
  if (empty()) return;
  for (int& motion : modes_.motions) archive.serialize_in_range(motion, -1, mode_released);
  for (int& contact : modes_.contacts) archive.serialize_in_range(contact, -1, 1);
  for (int i = 0; any_latch_ && i < count(); ++i) archive.serialize_in_range(modes_.latched[i], 0, 1);
  archive.serialize(modes_.leaves_from);
  archive.serialize_in_range(modes_.unstoppable, -1, 2 * static_cast<int>(sides_.size()) - 1);
  archive.serialize(counts_.impacts, counts_.closed_series, counts_.ambiguous);
  if (!archive.reading()) return;
  std::ranges::fill(triggered_, nothing);  // a step may have been given up between an event and what follows
  doubtful_.clear();
  hold();
}

}  // namespace gelenk
