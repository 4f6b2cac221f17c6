// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/joint_decisions.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kinematics/force_modes.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Of the accelerations to which rounding is relative: half of what a force that exceeds its limit by its slack causes
// (ForceRounding::slack).
constexpr double noticed_fraction = 2e-11;

}  // namespace

void JointDecisions::add(int lock) {
  const auto at = static_cast<std::size_t>(lock);
  LockProblem::Lock& out = problem_.locks.emplace_back();
  out.lock = lock;
  out.sticking = forces_.sticking_limit(lock);
  out.slipping = forces_.slipping_limit(lock);
  out.has_load = modes_.has_friction(lock) && forces_.loads().acts_on(forces_.lock(lock).friction);
  if (holding_friction_ > 0 && out.has_load && !out.sticking.vanishes)
    out.sticking.positive = out.sticking.negative = holding_friction_;
  out.contact = next_.contacts[at];
  out.triggered = modes_.triggered_[at] != LockModes::nothing && modes_.rests(lock);
  next_.motions[at] = mode_released;
}

// Friction is at rest, without a force, and limits are left.
void JointDecisions::keep_latched(int lock) {
  const auto at = static_cast<std::size_t>(lock);
  next_.motions[at] = modes_.has_friction(lock) ? 0 : mode_released;
  next_.contacts[at] = 0;
  next_.leaves_from[at] = 0;
}

void JointDecisions::begin(double t, const double* y) {
  problem_.locks.clear();
  problem_.unstoppable = {};
  if (modes_.empty()) return;
  modes_.equations_.bring_inputs(t, y);  // on which limits depend
  const double* v = y + modes_.nq_;
  before_ = next_ = modes_.state();
  for (int i = 0; i < modes_.count(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (modes_.is_latched(i)) {
      keep_latched(i);
      continue;
    }
    const bool slow = modes_.is_slow(i, v) || modes_.triggered_[at] != LockModes::nothing;
    next_.contacts[at] = slow ? modes_.touched_side(i) : 0;
    const double speed = forces_.speed(i, v);
    next_.motions[at] = slow || !modes_.has_friction(i) ? mode_released : speed > 0 ? 1 : -1;
    if (slow && (modes_.has_friction(i) || next_.contacts[at] != 0)) add(i);
  }
  LockModes::State open = next_;
  std::ranges::fill(open.contacts, 0);
  modes_.set_state(open);
}

void JointDecisions::begin_check() {
  problem_.locks.clear();
  problem_.unstoppable = {};
  if (modes_.empty()) return;
  before_ = next_ = modes_.state();
  for (int i = 0; i < modes_.count(); ++i) {
    if (!modes_.rests(i) || modes_.is_latched(i)) continue;
    add(i);
    problem_.locks.back().triggered = false;
  }
  find_noticed_accelerations();
  LockModes::State open = next_;
  std::ranges::fill(open.contacts, 0);
  modes_.set_state(open);
}

bool JointDecisions::add_returning(const double* y, const double* vdot) {
  if (modes_.empty()) return false;
  const double* v = y + modes_.nq_;
  const std::size_t before = problem_.locks.size();
  for (int i = 0; i < modes_.count(); ++i) {
    const int side = forces_.lock(i).limit < 0 ? 0 : modes_.touched_side(i);
    if (side == 0 || next_.contacts[static_cast<std::size_t>(i)] != 0) continue;
    const double leaving = -side * forces_.speed(i, v);
    if (!(leaving > 0) || !modes_.returns_to(i, side, 0, leaving, side * forces_.speed(i, vdot))) continue;
    next_.contacts[static_cast<std::size_t>(i)] = side;
    add(i);
  }
  find_noticed_accelerations();
  if (problem_.locks.size() == before) return false;
  LockModes::State released = modes_.state();
  released.motions = next_.motions;
  modes_.set_state(released);
  return true;
}

void JointDecisions::add_rows() {
  for (LockProblem::Lock& at : problem_.locks) at.row = modes_.row(at.lock);
}

// With the factors of the last solve(), at the same position.
void JointDecisions::find_noticed_accelerations() {
  if (problem_.locks.empty()) return;
  std::vector<int> locks;
  for (const LockProblem::Lock& at : problem_.locks) locks.push_back(at.lock);
  Eigen::MatrixXd W;
  VectorXd scale;
  forces_.compliance(locks, W, scale);
  for (std::size_t i = 0; i < locks.size(); ++i)
    problem_.locks[i].noticed = noticed_fraction * scale[static_cast<Index>(i)];
}

// What begins to move, or remains at rest.
void JointDecisions::take_up(LockModes::State& next, const LockProblem::Lock& at) {
  const auto lock = static_cast<std::size_t>(at.lock);
  const bool has_friction = modes_.has_friction(at.lock);
  if (at.leaves && at.direction != 0) {
    next.motions[lock] = has_friction ? at.direction : mode_released;
    next.contacts[lock] = 0;
    next.leaves_from[lock] = modes_.leaving_depth_of(at.lock);
    return;
  }
  if (at.leaves) modes_.doubtful_.push_back(at.lock);
  if (!has_friction) return;
  const bool keeps = at.direction != 0 && at.direction == modes_.modes_.motions[lock] &&
                     modes_.triggered_[lock] == LockModes::nothing && next.contacts[lock] == 0;
  next.motions[lock] = keeps ? modes_.modes_.motions[lock] : 0;
}

LockModes::State JointDecisions::answered() {
  LockModes::State out = next_;
  for (const LockProblem::Lock& at : problem_.locks) take_up(out, at);
  if (const auto& beyond = problem_.unstoppable; beyond.lock >= 0)
    out.unstoppable = modes_.limit_indicator(beyond.lock, beyond.side);
  return out;
}

void JointDecisions::try_answers() {
  if (modes_.empty()) return;
  modes_.set_state(before_);
  modes_.set_state(answered());
}

void JointDecisions::read_forces() {
  if (modes_.empty()) return;
  // Of redundant ones those that use limits the least: what others can hold is not beyond its limit.
  std::vector<double> forces;
  modes_.distribute(forces);
  for (LockProblem::Lock& at : problem_.locks) {
    at.holding = forces[static_cast<std::size_t>(at.lock)];
    at.slack = forces_.slack(at.lock);
  }
}

LockModes::State JointDecisions::end() {
  if (modes_.empty()) return {};
  modes_.set_state(before_);
  forget_doubts();  // those of tried answers
  return answered();
}

bool JointDecisions::enter(double t, LockModes::State next, Recording records) {
  if (modes_.empty()) return false;
  for (const int lock : modes_.doubtful_) {
    if (records == Recording::nothing) break;  // a preview is without effect on the run
    ++modes_.counts_.ambiguous;
    const int friction = forces_.lock(lock).friction;
    modes_.log_.add({t, 2 * (friction >= 0 ? friction : forces_.lock(lock).limit), friction < 0, true});
  }
  forget_doubts();
  const bool changed = next != modes_.state();
  modes_.enter(std::move(next), records);
  return changed;
}

LockModes::State JointDecisions::all_at_rest(double t, const double* y) {
  begin(t, y);
  LockModes::State out = next_;
  modes_.set_state(before_);
  for (const LockProblem::Lock& at : problem_.locks) {
    if (modes_.has_friction(at.lock)) out.motions[static_cast<std::size_t>(at.lock)] = 0;
  }
  return out;
}

double JointDecisions::largest_holding_force(double t, const double* y) {
  find_loads(t, y);
  std::vector<double> forces;
  modes_.distribute(forces);
  double out = 0;
  for (const double force : forces) out = std::max(out, std::abs(force));
  return out;
}

std::vector<double> JointDecisions::limits() const {
  std::vector<double> out;
  for (int i = 0; i < forces_.locks(); ++i) {
    const DirectedLimit limit = forces_.sticking_limit(i);
    out.push_back(limit.positive);
    out.push_back(limit.negative);
  }
  return out;
}

void JointDecisions::doubt_all() {
  for (const LockProblem::Lock& at : problem_.locks) modes_.doubtful_.push_back(at.lock);
}

}  // namespace gelenk
