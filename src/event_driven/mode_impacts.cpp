// SPDX-License-Identifier: BSD-3-Clause
// Impacts, and what contacts do after them: the part of ModeChanges that changes velocities.
#include <algorithm>
#include <cmath>

#include "event_driven/mode_changes.h"
#include "mechanism/mechanism.h"
#include "nonsmooth/rounding.h"
#include "nonsmooth/stop_audit.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Part of the fastest approach with which something may still approach after an impact.
constexpr double approaching_fraction = 1e-3;
// Of a rebound that stops, in units of the highest one that is lost: accelerations before and after an impact differ.
constexpr double stopped_height = 4;

}  // namespace

// The impulses of everything that is struck. returning: joints that stop as well. before: their modes before all that
// happens at this instant.
void ModeChanges::strike(double t, double* y, const std::vector<int>& returning, const LockModes::State& before) {
  double* const v = y + mechanism_.nq;
  const double rest = contacts_.slow(v);
  contacts_.go_to(y);
  std::vector<int> candidates;
  bool any = false;
  for (int i = 0; i < contact_equations_.candidates().count(); ++i) {
    if (contact_equations_.candidates()[i].is_given()) continue;  // a force of limited size exerts no impulse
    const bool closed = contacts_.mode_of(i).closed;
    if (!closed && !contacts_.may_touch(i)) continue;
    candidates.push_back(i);
    any = any || (contact_equations_.candidates().state(i).rate < -rest && !closed);
  }
  BeforeImpact at{.joints = joint_impacts_.struck(y, returning, before)};
  const std::vector<JointImpacts::Struck>& joints = at.joints;
  any = any || !returning.empty() || std::ranges::any_of(joints, &JointImpacts::Struck::approaches);
  if (!any) return;
  equations_.accelerations_at(t, y, vdot_.data());
  at.vdot = vdot_;
  for (const double a : vdot_) struck_acceleration_ = std::max(struck_acceleration_, std::abs(a));
  at.holding = joint_impacts_.holding_forces();
  order_.find(y, mechanism_.nq, vdot_);
  const std::vector<CandidateMode> present = contact_equations_.modes();
  const LockModes::State present_joints = joints_.state();
  const FrozenLoads frozen(dynamics_.switching_forces().loads());  // friction of joints exerts no impulses
  if (!candidates.empty()) {
    contact_equations_.set_modes(std::vector<CandidateMode>(present.size()));
    joint_impacts_.let_go();
    equations_.accelerations_at(t, y, vdot_.data());
  }
  ImpactEquations impact(contact_equations_, dynamics_.switching_forces(), candidates, joints, v, rest);
  bool found = impact.law().solve(decisions_.solver());
  dynamics_.count_evaluations(excess_iterations(impact.law().iterations()));
  at.accelerations = impact.accelerations(at.vdot.data());
  found = end_series(at, impact) && found;
  if (!candidates.empty()) {
    contact_equations_.set_modes(present);
    joints_.set_state(present_joints);
  }
  impact.apply(v);
  const int other = order_.changed(v);
  if (other >= 0) ++counts_.ambiguous;
  record_impacts(t, y, candidates, impact, found, other);
  std::vector<double> rebounds;
  for (std::size_t i = candidates.size(); i < impact.law().count(); ++i) rebounds.push_back(impact.law().rebound(i));
  joint_impacts_.finish(t, y, joints, rebounds, found, other);
  equations_.mode_changed();
}

void ModeChanges::record_impacts(double t, const double* y, const std::vector<int>& candidates,
                                 const ImpactEquations& impact, bool found, int other) {
  if (!found) ++counts_.ambiguous;
  if (candidates.empty()) return;
  // Impulses that miss their laws by little are used; none is found at all where what touches still approaches.
  double fastest = 0, least_rebound = INFINITY;
  for (std::size_t i = 0; i < impact.law().count(); ++i) {
    fastest = std::max(fastest, std::abs(impact.law().approach(i)));
    if (i < candidates.size()) least_rebound = std::min(least_rebound, impact.law().rebound(i));
  }
  constexpr int per_candidate = ContactModes::per_candidate;
  if (!found && least_rebound < -approaching_fraction * fastest) {
    refusal_ = log_.report({t, first_indicator_ + per_candidate * candidates.front(), true}).text +
               ", and no impulses were found that agree with the laws of impact (as where a heavy body strikes one of "
               "far less mass)";
  }
  const double rest = contacts_.slow(y + mechanism_.nq);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (!(impact.law().approach(i) < -rest)) continue;
    ++counts_.impacts;
    log_.add({t, first_indicator_ + per_candidate * candidates[i], true, !found, other});
  }
}

// Whether a rebound is lost in rounding, with the accelerations of `before`, by number.
bool ModeChanges::is_lost(std::size_t i, const BeforeImpact& before, const ImpactEquations& impact) const {
  const Impact& law = impact.law();
  const std::size_t contacts = law.count() - before.joints.size();
  const double rebound = law.rebound(i);
  if (!(rebound > 0)) return false;
  if (i < contacts)
    return law.restitution(i) != 0 && is_lost_contact(rebound, -before.accelerations[static_cast<Index>(i)]);
  return !law.is_held(i) && joint_impacts_.is_lost(before.joints[i - contacts], rebound, before.vdot.data(),
                                                   before.holding, law.mobility(i));
}

// What would rebound so little that it is lost in rounding has no restitution; a bound of a joint that others throw off
// so slowly stays closed: it would return, throw them off, and so on. Returns false if no impulses are found then.
bool ModeChanges::end_series(const BeforeImpact& before, ImpactEquations& impact) {
  Impact& law = impact.law();
  const std::size_t contacts = law.count() - before.joints.size();
  bool found = true;
  for (bool closed = true; closed;) {
    closed = false;
    for (std::size_t i = 0; i < law.count(); ++i) {
      if (!is_lost(i, before, impact)) continue;
      closed = true;
      if (i < contacts) {
        counts_.closed_series += law.approach(i) < 0 ? 1 : 0;
      } else {
        joint_impacts_.count_closed_series(before.joints[i - contacts]);
      }
      if (i >= contacts && law.restitution(i) == 0) {
        law.hold(i);
      } else {
        law.set_inelastic(i);
      }
    }
    if (closed) found = law.solve(decisions_.solver());
  }
  return found;
}

// Stops joints that are at rest within rounding; refuses to if that would change the motion.
void ModeChanges::stop_joints(double* y) {
  const double* const v = y + mechanism_.nq;
  std::copy_n(v, unstopped_.size(), unstopped_.begin());
  joints_.forget_events();  // what they let go has been decided on
  const int stopped = joints_.first_to_stop(y);
  joints_.finish(y);
  const double rebound = fastest_rebound(stopped_height * lowest_rebound * touch_tolerance, struck_acceleration_);
  if (stopped < 0 || excess_of_stop(unstopped_, {v, unstopped_.size()}, rebound) <= 1) return;
  refusal_ = joints_.text_of_stop(stopped) +
             ", and velocities would change by far more than rounding explains: try a smaller tolerance or another "
             "integrator";
}

// What is closed does not approach, and what is at rest, or begins to move from there, does not move.
void ModeChanges::finish(double* y) {
  std::ranges::fill(triggered_, Trigger{});
  stop_joints(y);
  if (contact_equations_.closed().empty()) return;
  double* const v = y + mechanism_.nq;
  const double rest = contacts_.slow(v);
  contacts_.go_to(y);
  const std::vector<CandidateMode> modes = contact_equations_.modes();
  std::vector<CandidateMode> stopped = modes;
  ContactEquations::Rows rows;
  contact_equations_.build(contact_equations_.closed(), modes, false, rows);
  for (const ContactEquations::Entry& entry : rows.entries) {
    for (std::size_t k = 0; k < contact_groups; ++k) {
      bool& moves = stopped[static_cast<std::size_t>(entry.candidate)].groups[k].moves;
      moves = moves && entry.slip[k].norm() > rest;
    }
  }
  contact_equations_.set_modes(stopped);
  contact_equations_.close_velocity(v);
  contact_equations_.set_modes(modes);
}

}  // namespace gelenk
