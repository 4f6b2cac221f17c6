// SPDX-License-Identifier: BSD-3-Clause
#include "modes/joint_locks.h"

#include <algorithm>
#include <cmath>

#include "event/lost_rebound.h"
#include "kinematics/branches.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Of the accelerations to which rounding is relative: half of what a force that exceeds its limit by its slack causes
// (Branching::slack).
constexpr double noticed_fraction = 2e-11;
// A speed towards a bound that an impact leaves, relative to the largest: no force can stop it.
constexpr double stopped_fraction = 1e-8;

}  // namespace

JointLocks::JointLocks(LockModes& modes, int nv) : modes_(modes), forces_(modes.forces_) {
  VectorXd unit = VectorXd::Zero(nv);
  for (int i = 0; i < forces_.locks(); ++i) {
    VectorXd row(nv);
    for (Index k = 0; k < nv; ++k) {
      unit[k] = 1;
      row[k] = forces_.speed(i, unit.data());
      unit[k] = 0;
    }
    rows_.push_back(row);
  }
}

bool JointLocks::recall(double t, const double* y) {
  if (empty()) return false;
  modes_.find_events_at_start(t, y);
  const bool decides = modes_.started_ || is_triggered() || modes_.is_doubtful(t, y, modes_.jumped_);
  modes_.jumped_ = modes_.started_ = false;
  return decides;
}

bool JointLocks::are_doubtful(double t, const double* y) {
  return !empty() && (modes_.started_ || modes_.is_doubtful(t, y, true));
}

bool JointLocks::is_triggered() const {
  return std::ranges::any_of(modes_.triggered_, [](auto trigger) { return trigger != LockModes::nothing; });
}

std::size_t JointLocks::find_yielding(double* g, std::vector<double*>& out) const {
  std::size_t resting = 0;
  for (int i = 0; i < modes_.count(); ++i) {
    if (!modes_.rests(i)) continue;
    ++resting;
    const Branching::Lock lock = forces_.lock(i);
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

std::vector<JointLocks::Struck> JointLocks::struck(const double* y, const std::vector<int>& returning,
                                                   const LockModes::State& before) const {
  const double* v = y + modes_.nq_;
  std::vector<Struck> out;
  for (int i = 0; i < modes_.count(); ++i) {
    const Branching::Lock lock = forces_.lock(i);
    const int side = lock.limit < 0 ? 0 : modes_.touched_side(i);
    const bool returns = std::ranges::find(returning, i) != returning.end();
    if (side == 0 && !returns) continue;
    const double speed = forces_.speed(i, v);
    const bool approaches = side * speed > 0 && !modes_.is_slow(i, v);
    out.push_back({i,
                   {side, speed, returns ? 0 : lock.restitution, lock.poisson, returns},
                   approaches || (returns && side != 0 && before.contacts[i] == 0),
                   rows_[static_cast<std::size_t>(i)]});
  }
  return out;
}

void JointLocks::let_go() {
  LockModes::State open = state();
  for (int i = 0; i < modes_.count(); ++i) {
    if (!modes_.rests(i)) continue;
    open.motions[i] = branch_released;
    open.contacts[i] = 0;
  }
  set_state(open);
}

bool JointLocks::is_lost(const Struck& at, double speed, double acceleration) const {
  if (forces_.lock(at.lock).one_way) return false;
  const double tolerance = forces_.depth(at.lock, at.is.side).tolerance;
  return rises_no_higher(lowest_rebound * tolerance, speed, acceleration);
}

void JointLocks::finish_impact(double t, const double* y, const std::vector<Struck>& struck, const VectorXd& rebounds,
                               bool found, int closed_series) {
  modes_.counts_.closed_series += closed_series;
  const double* v = y + modes_.nq_;
  double fastest = 1;
  for (int k = 0; k < modes_.nv_; ++k) fastest = std::max(fastest, std::abs(v[k]));
  for (std::size_t i = 0; i < struck.size(); ++i) {
    const Struck& at = struck[i];
    if (at.is.side == 0) continue;
    const int indicator = modes_.limit_indicator(at.lock, at.is.side);
    if (at.approaches) {
      ++modes_.counts_.impacts;
      if (!forces_.lock(at.lock).one_way) modes_.log_.add({t, indicator, true, !found});
    }
    if (rebounds[static_cast<Index>(i)] < -stopped_fraction * fastest) modes_.modes_.unstoppable = indicator;
    modes_.modes_.leaves_from[at.lock] = modes_.modes_.contacts[at.lock] == 0 ? modes_.leaving_depth(at.lock) : 0;
  }
  for (int i = 0; i < modes_.count(); ++i) {
    if (!modes_.is_slow(i, v)) modes_.triggered_[i] = LockModes::nothing;
  }
}

void JointLocks::add(int lock) {
  const Branching::Lock of = forces_.lock(lock);
  LockProblem::Lock& out = problem_.locks.emplace_back();
  out.lock = lock;
  out.row = rows_[static_cast<std::size_t>(lock)];
  out.sticking = of.sticking_limit.largest();  // of friction that depends on no loads, which is without direction
  out.slipping = of.slipping_limit.largest();
  out.contact = next_.contacts[lock];
  out.triggered = modes_.triggered_[lock] != LockModes::nothing && modes_.rests(lock);
  next_.motions[lock] = branch_released;
}

void JointLocks::begin_decision(double t, const double* y) {
  problem_.locks.clear();
  if (empty()) return;
  modes_.equations_.bring_inputs(t);  // on which limits depend
  const double* v = y + modes_.nq_;
  modes_.drop_rebounds(v);
  before_ = next_ = state();
  next_.unstoppable = -1;
  for (int i = 0; i < modes_.count(); ++i) {
    const bool slow = modes_.is_slow(i, v) || modes_.triggered_[i] != LockModes::nothing;
    next_.contacts[i] = slow ? modes_.touched_side(i) : 0;
    const double speed = forces_.speed(i, v);
    next_.motions[i] = !modes_.has_friction(i) ? branch_released : speed > 0 ? 1 : -1;
    if (!slow) continue;
    next_.motions[i] = branch_released;
    if (modes_.has_friction(i) || next_.contacts[i] != 0) add(i);
  }
  LockModes::State open = next_;
  std::ranges::fill(open.contacts, 0);
  set_state(open);
}

void JointLocks::begin_check() {
  problem_.locks.clear();
  if (empty()) return;
  before_ = next_ = state();
  for (int i = 0; i < modes_.count(); ++i) {
    if (!modes_.rests(i)) continue;
    add(i);
    problem_.locks.back().triggered = false;
  }
  find_noticed_accelerations();
  LockModes::State open = next_;
  std::ranges::fill(open.contacts, 0);
  set_state(open);
}

bool JointLocks::add_returning(const double* y, const double* vdot) {
  if (empty()) return false;
  const LockModes::State open = state();
  const std::size_t before = problem_.locks.size();
  for (const Struck& at : struck(y, {}, before_)) {
    const double leaving = -at.is.side * at.is.speed;
    const double back = at.is.side * forces_.speed(at.lock, vdot);
    if (next_.contacts[at.lock] != 0 || !(leaving > 0) || !is_lost(at, leaving, back)) continue;
    next_.contacts[at.lock] = at.is.side;
    add(at.lock);
  }
  find_noticed_accelerations();
  if (problem_.locks.size() == before) return false;
  LockModes::State released = open;
  released.motions = next_.motions;
  set_state(released);
  return true;
}

// With the factors of the last solve(), at the same position.
void JointLocks::find_noticed_accelerations() {
  if (problem_.locks.empty()) return;
  std::vector<int> locks;
  for (const LockProblem::Lock& at : problem_.locks) locks.push_back(at.lock);
  Eigen::MatrixXd W;
  VectorXd scale;
  forces_.compliance(locks, W, scale);
  for (std::size_t i = 0; i < locks.size(); ++i)
    problem_.locks[i].noticed = noticed_fraction * scale[static_cast<Index>(i)];
}

void JointLocks::decide_alone(const double* vdot) {
  std::vector<int> undecided;
  bool breaks_away = false;
  for (const LockProblem::Lock& at : problem_.locks) {
    undecided.push_back(at.lock);
    breaks_away = breaks_away || at.triggered;
  }
  std::copy_n(vdot, modes_.nv_, modes_.vdot_.begin());
  set_state(before_);
  modes_.decide(next_, undecided, breaks_away);
  problem_.locks.clear();  // the answers are in next_
}

LockModes::State JointLocks::answered() {
  LockModes::State out = next_;
  for (const LockProblem::Lock& at : problem_.locks) modes_.take_up(out, at.lock, at.leaves, at.direction);
  return out;
}

void JointLocks::try_answers() {
  set_state(before_);
  set_state(answered());
}

void JointLocks::read_forces() {
  // Of redundant ones those that use limits the least: what others can hold is not beyond its limit.
  std::vector<double> forces;
  modes_.distribute(forces);
  for (LockProblem::Lock& at : problem_.locks) {
    at.holding = forces[static_cast<std::size_t>(at.lock)];
    at.slack = forces_.slack(at.lock);
  }
}

bool JointLocks::end_decision(double t, Recording records) {
  if (empty()) return false;
  set_state(before_);
  const LockModes::State after = answered();
  modes_.record_doubtful(t, records != Recording::nothing);
  const bool changed = after != before_;
  modes_.enter(t, after, records);
  return changed;
}

}  // namespace gelenk
