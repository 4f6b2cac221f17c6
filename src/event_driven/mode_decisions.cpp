// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/mode_decisions.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "kinematics/loads.h"
#include "mechanism/mechanism.h"
#include "nonsmooth/rounding.h"

namespace gelenk {

using Eigen::VectorXd;

namespace {

// Decisions where limits depend on loads, and the relative change of limits at which they are repeated no more.
constexpr int most_decisions = 60;
constexpr double load_tolerance = 1e-13;
// Friction that holds all that it might, in units of the largest force that keeps a joint at rest: a part of what opens
// can press on it as levers permit.
constexpr double holding_friction = 1e3;

}  // namespace

bool is_lost_contact(double speed, double acceleration) {
  return rises_no_higher(lowest_rebound * touch_tolerance, speed, acceleration);
}

bool differ(const std::vector<CandidateMode>& a, const std::vector<CandidateMode>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    bool same = a[i].closed == b[i].closed;
    for (std::size_t k = 0; k < contact_groups; ++k) same = same && a[i].groups[k].moves == b[i].groups[k].moves;
    if (!same) return true;
  }
  return false;
}

ModeDecisions::ModeDecisions(const Context& context)
    : mechanism_(context.mechanism),
      dynamics_(context.dynamics),
      equations_(context.equations),
      modes_(context.joints),
      contacts_(context.contacts),
      contact_equations_(context.contacts.equations()),
      joints_(context.joints),
      decision_(contact_equations_),
      vdot_(static_cast<std::size_t>(context.mechanism.nv)) {}

ModeDecisions::Modes ModeDecisions::decide(double t, const double* y, Asked asked,
                                           const std::vector<Trigger>& triggered) {
  agrees_with_loads_ = true;
  if (dynamics_.switching_forces().loads().empty() || modes_.empty()) return find(t, y, asked, triggered);
  return find_with_loads(t, y, asked, triggered);
}

// With the limits of friction at the last solve(), in the present modes, which are entered again.
ModeDecisions::Modes ModeDecisions::find(double t, const double* y, Asked asked,
                                         const std::vector<Trigger>& triggered) {
  const std::vector<CandidateMode> present = contact_equations_.modes();
  std::vector<CandidateMode> next = present;
  const bool asks_contacts = asked == Asked::all && contacts_.any();
  if (asks_contacts) {
    next.assign(present.size(), {});
    contact_equations_.set_modes(next);
  }
  dynamics_.set_position(y);
  joints_.begin(t, y);
  // What an engaged latch holds is not decided on, but stopped with these factors, too.
  if (asks_contacts || !joints_.problem().locks.empty() || modes_.any_at_rest())
    equations_.accelerations_at(t, y, vdot_.data());
  if (asks_contacts && joints_.add_returning(y, vdot_.data())) equations_.accelerations_at(t, y, vdot_.data());
  outcome_ = ContactDecision::Outcome::found;
  decided_candidate_ = -1;
  if (asks_contacts) find_contact_modes(t, y, triggered, next);
  if (decided_candidate_ < 0 && !joints_.problem().locks.empty())
    decide_on_joints(dynamics_.switching_forces(), vdot_.data(), joints_.problem());
  if (asks_contacts) {
    contact_equations_.set_modes(present);
    dynamics_.set_position(y);
  }
  return {joints_.end(), std::move(next)};
}

// The modes in which friction that depends on loads holds all joints that it might: what opens or slips then carries no
// load, or that of its motion.
ModeDecisions::Modes ModeDecisions::find_held(double t, const double* y, Asked asked,
                                              const std::vector<Trigger>& triggered) {
  const Modes before{modes_.state(), contact_equations_.modes()};
  Modes held{joints_.all_at_rest(t, y), before.contacts};
  if (!joints_.any_without_load() && (asked == Asked::joints || !contacts_.any())) return held;
  set_joints(held.joints);
  joints_.hold_by_friction(holding_friction * joints_.largest_holding_force(t, y));
  set_joints(before.joints);
  const FrozenLoads frozen(dynamics_.switching_forces().loads());
  held = find(t, y, asked, triggered);
  joints_.hold_by_friction(0);
  return held;
}

// Where the limits of friction depend on the modes that they decide on, the decision is repeated with the limits in the
// modes decided on, until both agree. It begins with all joints at rest, since what can remain at rest does.
ModeDecisions::Modes ModeDecisions::find_with_loads(double t, const double* y, Asked asked,
                                                    const std::vector<Trigger>& triggered) {
  const Modes before{modes_.state(), contact_equations_.modes()};
  dynamics_.set_position(y);
  Modes next = find_held(t, y, asked, triggered);
  std::vector<double> known;
  for (int round = 0; round < most_decisions; ++round) {
    joints_.forget_doubts();
    set_joints(next.joints);
    contact_equations_.set_modes(next.contacts);
    joints_.find_loads(t, y);
    const std::vector<double> now = joints_.limits();
    set_joints(before.joints);
    contact_equations_.set_modes(before.contacts);
    const Modes decided = std::move(next);
    {
      const FrozenLoads frozen(dynamics_.switching_forces().loads());
      next = find(t, y, asked, triggered);
    }
    double change = known.empty() ? INFINITY : 0, largest = 0;
    for (std::size_t i = 0; i < known.size(); ++i) change = std::max(change, std::abs(now[i] - known[i]));
    for (const double limit : now) largest = std::max(largest, limit);
    if (next.joints == decided.joints && !differ(next.contacts, decided.contacts) && change <= load_tolerance * largest)
      return next;
    known = now;
  }
  joints_.doubt_all();
  agrees_with_loads_ = false;
  return next;
}

// The load of the present solution does not decide: where only forces that nothing can exert keep joints at rest, it
// may be zero.
int ModeDecisions::seizing(double t, const double* y) {
  if (agrees_with_loads_) return -1;
  LoadDependence& loads = dynamics_.switching_forces().loads();
  const auto count = static_cast<std::size_t>(loads.signed_count());
  const auto signs = std::make_unique<bool[]>(count);
  const LockModes::State present = modes_.state();
  set_joints(joints_.all_at_rest(t, y));
  int out = -1;
  for (const bool positive : {true, false}) {
    std::fill_n(signs.get(), count, positive);
    loads.hold_signs(signs.get());
    joints_.find_loads(t, y);
    out = std::max(out, loads.seized());
  }
  loads.hold_signs(nullptr);
  set_joints(present);
  return out;
}

// The candidates that touch and remain closed if forces keep them so, at the state of the last solve() with the
// accelerations vdot_: those with a normal velocity of zero, or one so low that they would return before they have left
// the rounding of their positions.
std::vector<int> ModeDecisions::lasting(double rest) {
  std::vector<int> touching;
  for (int i = 0; i < contact_equations_.candidates().count(); ++i) {
    if (contacts_.may_touch(i)) touching.push_back(i);
  }
  std::vector<int> out;
  ContactEquations::Rows rows;
  contact_equations_.build(touching, contact_equations_.modes(), false, rows);
  const Eigen::Map<const VectorXd> vdot(vdot_.data(), mechanism_.nv);
  for (const ContactEquations::Entry& entry : rows.entries) {
    const double rate = entry.at.rate;
    const double fall = -rows.rates[entry.first] - rows.R.row(entry.first).dot(vdot);
    const bool returns = rate > 0 && is_lost_contact(rate, fall);
    if (std::abs(rate) <= rest || returns) out.push_back(entry.candidate);
  }
  return out;
}

// next: out, with the accelerations vdot_ of what is free.
void ModeDecisions::find_contact_modes(double t, const double* y, const std::vector<Trigger>& triggered,
                                       std::vector<CandidateMode>& next) {
  contacts_.go_to(y);
  for (int i = 0; i < contact_equations_.candidates().count(); ++i) {
    if (contacts_.may_touch(i))
      next[static_cast<std::size_t>(i)].leaves_from =
          leaving_depth(-contact_equations_.candidates().gap(i), touch_tolerance);
  }
  const double rest = contacts_.slow(y + mechanism_.nq);
  const std::vector<int> candidates = lasting(rest);
  if (candidates.empty()) return;
  ContactEquations::Rows rows;
  contact_equations_.build(candidates, next, false, rows);
  for (const ContactEquations::Entry& entry : rows.entries) {
    CandidateMode& mode = next[static_cast<std::size_t>(entry.candidate)];
    mode.closed = true;
    for (std::size_t k = 0; k < contact_groups; ++k) {
      const double speed = entry.slip[k].norm();
      mode.groups[k].moves = entry.rows[k] >= 0 && speed > rest;
      if (mode.groups[k].moves) mode.groups[k].direction = entry.slip[k] / speed;
    }
  }
  set_accelerations(t, y);
  decided_candidate_ = candidates.front();
  outcome_ = decide_on(candidates, triggered, next);
}

ContactDecision::Outcome ModeDecisions::decide_on(const std::vector<int>& candidates,
                                                  const std::vector<Trigger>& triggered,
                                                  std::vector<CandidateMode>& next) {
  const auto outcome = decision_.decide(candidates, triggered, vdot_.data(), next, joints_.problem());
  dynamics_.count_evaluations(excess_iterations(decision_.iterations()));
  return outcome;
}

// Completes the problem of joints for a decision with contacts.
void ModeDecisions::set_accelerations(double t, const double* y) {
  joints_.add_rows();
  joints_.problem().accelerate = [this, t, y](double* vdot) {
    dynamics_.set_position(y);
    joints_.try_answers();
    equations_.accelerations_at(t, y, vdot);
    joints_.read_forces();
  };
}

bool ModeDecisions::hold_by_others(double t, const double* y) {
  const std::vector<CandidateMode> present = contact_equations_.modes();
  const LockModes::State present_joints = modes_.state();
  const std::vector<int> candidates(contact_equations_.closed().begin(), contact_equations_.closed().end());
  const FrozenLoads frozen(dynamics_.switching_forces().loads());
  contact_equations_.set_modes(std::vector<CandidateMode>(present.size()));
  joints_.begin_check();
  equations_.accelerations_at(t, y, vdot_.data());
  std::vector<CandidateMode> next = present;
  set_accelerations(t, y);
  const auto outcome = decide_on(candidates, std::vector<Trigger>(present.size()), next);
  contact_equations_.set_modes(present);
  set_joints(present_joints);
  bool holds = outcome == ContactDecision::Outcome::found;
  for (const int candidate : candidates) {
    const auto i = static_cast<std::size_t>(candidate);
    holds = holds && next[i].closed;
    for (std::size_t k = 0; k < contact_groups; ++k)
      holds = holds && (present[i].groups[k].moves || !next[i].groups[k].moves);
  }
  return holds && std::ranges::none_of(joints_.problem().locks, &LockProblem::Lock::leaves);
}

}  // namespace gelenk
