// SPDX-License-Identifier: BSD-3-Clause
// What follows where contacts are struck or let go: the part of TouchModes that decides.
#include <algorithm>
#include <utility>

#include "contact/contact_finder.h"
#include "event/lost_rebound.h"
#include "mechanism/mechanism.h"
#include "touch/touch_modes.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// What leaves may be closer than touching by rounding, and go further by this fraction of what counts as contact before
// it touches again.
constexpr double leaving_fraction = 0.1;
// Part of the fastest approach with which something may still approach after an impact.
constexpr double approaching_fraction = 1e-3;

// Whether a rebound at this speed is lost in the rounding of the position, for this acceleration back.
bool is_lost(double speed, double acceleration) {
  return rises_no_higher(lowest_rebound * touch_tolerance, speed, acceleration);
}

// Whether they differ in what is closed and what moves.
bool differ(const std::vector<SpotMode>& a, const std::vector<SpotMode>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    bool same = a[i].closed == b[i].closed;
    for (std::size_t k = 0; k < contact_groups; ++k) same = same && a[i].groups[k].moves == b[i].groups[k].moves;
    if (!same) return true;
  }
  return false;
}

double leaving_depth(double gap) { return std::max(0.0, -gap) + leaving_fraction * touch_tolerance; }

}  // namespace

// The impulses of everything that is struck. returning: joints that stop as well. before: their modes before all that
// happens at this instant.
void TouchModes::strike(double t, double* y, const std::vector<int>& returning, const LockModes::State& before) {
  double* const v = y + mechanism_.nq;
  const double rest = slow(v);
  go_to(y);
  std::vector<int> struck;
  bool any = false;
  for (int i = 0; i < touch_.spots().count(); ++i) {
    if (!mode_of(i).closed && !may_touch(i)) continue;
    const SpotState at = touch_.spots().state(i);
    struck.push_back(i);
    any = any || (at.rate < -rest && !mode_of(i).closed);
  }
  const std::vector<JointLocks::Struck> limits = locks_.struck(y, returning, before);
  any = any || !returning.empty() || std::ranges::any_of(limits, &JointLocks::Struck::approaches);
  if (!any) return;
  equations_.touched_accelerations(t, y, vdot_.data());
  const std::vector<double> at_rest = vdot_;  // with what is kept at rest
  const std::vector<SpotMode> present = touch_.modes();
  const LockModes::State present_locks = locks_.state();
  touch_.set_modes(std::vector<SpotMode>(present.size()));
  locks_.let_go();
  equations_.touched_accelerations(t, y, vdot_.data());
  std::vector<ContactImpact::StruckLimit> rows;
  for (const JointLocks::Struck& limit : limits) rows.push_back({limit.row, limit.is});
  ContactImpact impact(touch_, struck, rows, v, rest);
  const bool found = impact.solve(decision_.solver());
  const int closed_series = end_series(limits, at_rest.data(), impact);
  touch_.set_modes(present);
  locks_.set_state(present_locks);
  impact.apply(v);
  record_impacts(t, y, struck, impact, found);
  locks_.finish_impact(t, y, limits, impact.rebounds().tail(static_cast<Index>(limits.size())), found, closed_series);
  equations_.touch_changed();
}

void TouchModes::record_impacts(double t, const double* y, const std::vector<int>& struck, const ContactImpact& impact,
                                bool found) {
  if (!found) ++counts_.ambiguous;
  // Impulses that miss their laws by little are used; none is found at all where what touches still approaches.
  const VectorXd rebounds = impact.rebounds();
  const double permitted = approaching_fraction * impact.approach().cwiseAbs().maxCoeff();
  if (!found && rebounds.head(static_cast<Index>(struck.size())).minCoeff() < -permitted) {
    refusal_ = log_.report({t, first_indicator_ + per_spot * struck.front(), true}).text +
               ", and no impulses were found that agree with the laws of impact (as where a heavy body strikes one of "
               "far less mass)";
  }
  const double rest = slow(y + mechanism_.nq);
  for (std::size_t i = 0; i < struck.size(); ++i) {
    if (!(impact.approach()[static_cast<Index>(i)] < -rest)) continue;
    ++counts_.impacts;
    log_.add({t, first_indicator_ + per_spot * struck[i], true, !found});
  }
}

// What would rebound so little that it is lost in rounding, with the accelerations vdot, has no restitution. Returns
// the number of limits of which a series of impacts has ended.
int TouchModes::end_series(const std::vector<JointLocks::Struck>& limits, const double* vdot, ContactImpact& impact) {
  long limits_ended = 0;
  const std::size_t contacts = impact.count() - limits.size();
  for (bool closed = true; closed;) {
    closed = false;
    const VectorXd rebounds = impact.rebounds();
    const VectorXd falls = impact.accelerations(vdot);
    for (std::size_t i = 0; i < impact.count(); ++i) {
      const auto at = static_cast<Index>(i);
      if (impact.restitution(i) == 0 || !(rebounds[at] > 0)) continue;
      const bool lost = i < contacts ? is_lost(rebounds[at], -falls[at])
                                     : locks_.is_lost(limits[i - contacts], rebounds[at], -falls[at]);
      if (!lost) continue;
      impact.set_inelastic(i);
      closed = true;
      if (!(impact.approach()[at] < 0)) continue;
      (i < contacts ? counts_.closed_series : limits_ended) += 1;
    }
    if (closed) impact.solve(decision_.solver());
  }
  return static_cast<int>(limits_ended);
}

// The spots that touch and remain closed if forces keep them so, at the state of the last solve() with the
// accelerations vdot_: those with a normal velocity of zero, or one so low that they would return before they have left
// the rounding of their positions.
std::vector<int> TouchModes::lasting(double rest) {
  std::vector<int> touching;
  for (int i = 0; i < touch_.spots().count(); ++i) {
    if (may_touch(i)) touching.push_back(i);
  }
  std::vector<int> out;
  TouchEquations::Rows rows;
  touch_.build(touching, touch_.modes(), false, rows);
  const Eigen::Map<const VectorXd> vdot(vdot_.data(), mechanism_.nv);
  for (const TouchEquations::Entry& entry : rows.entries) {
    const double rate = entry.at.rate;
    const double fall = -rows.rates[entry.first] - rows.R.row(entry.first).dot(vdot);
    const bool returns = rate > 0 && is_lost(rate, fall);
    if (std::abs(rate) <= rest || returns) out.push_back(entry.spot);
  }
  return out;
}

// The modes that follow at (t, y). What moves keeps moving; on what is at rest accelerations decide. Returns whether
// they are others.
bool TouchModes::decide(double t, const double* y, Recording records) {
  const std::vector<SpotMode> present = touch_.modes();
  std::vector<SpotMode> next(present.size());
  touch_.set_modes(next);
  dynamics_.set_position(y);
  locks_.begin_decision(t, y);
  equations_.touched_accelerations(t, y, vdot_.data());
  if (locks_.add_returning(y, vdot_.data())) equations_.touched_accelerations(t, y, vdot_.data());
  go_to(y);
  for (int i = 0; i < touch_.spots().count(); ++i) {
    if (may_touch(i)) next[static_cast<std::size_t>(i)].leaves_from = leaving_depth(touch_.spots().gap(i));
  }
  find_modes(y, records != Recording::nothing, t, next);
  touch_.set_modes(present);
  dynamics_.set_position(y);
  const bool changed = locks_.end_decision(t, records) || differ(present, next);
  enter(std::move(next), records);
  return changed;
}

// next: out, with the accelerations vdot_ of what is free.
void TouchModes::find_modes(const double* y, bool logs, double t, std::vector<SpotMode>& next) {
  const double rest = slow(y + mechanism_.nq);
  const std::vector<int> spots = lasting(rest);
  if (spots.empty()) {
    if (!locks_.problem().locks.empty()) locks_.decide_alone(vdot_.data());
    return;
  }
  TouchEquations::Rows rows;
  touch_.build(spots, next, false, rows);
  for (const TouchEquations::Entry& entry : rows.entries) {
    SpotMode& mode = next[static_cast<std::size_t>(entry.spot)];
    mode.closed = true;
    for (std::size_t k = 0; k < contact_groups; ++k) {
      const double speed = entry.slip[k].norm();
      mode.groups[k].moves = entry.rows[k] >= 0 && speed > rest;
      if (mode.groups[k].moves) mode.groups[k].direction = entry.slip[k] / speed;
    }
  }
  set_accelerations(t, y);
  const auto outcome = decision_.decide(spots, triggered_, vdot_.data(), next, locks_.problem());
  if (outcome == ContactDecision::Outcome::found || !logs) return;
  ++counts_.ambiguous;
  log_.add({t, first_indicator_ + per_spot * spots.front(), true, true});
  if (outcome != ContactDecision::Outcome::none) return;
  refusal_ = log_.report({t, first_indicator_ + per_spot * spots.front(), true}).text +
             ", and no contact forces were found that agree with Coulomb's law (as in Painlev\u00e9's paradox)";
}

void TouchModes::enter(std::vector<SpotMode> next, Recording records) {
  for (SpotMode& after : next) {
    if (after.closed) after.leaves_from = 0;
    if (!after.closed) after.groups = {};
  }
  const bool changed = next != touch_.modes();
  touch_.set_modes(next);
  if (changed && records != Recording::nothing) equations_.touch_changed();
}

// Records how the modes differ from those before.
void TouchModes::record_changes(double t, const std::vector<SpotMode>& modes_before) {
  for (std::size_t i = 0; i < modes_before.size(); ++i) {
    const SpotMode& before = modes_before[i];
    const SpotMode& after = touch_.modes()[i];
    const int first = first_indicator_ + per_spot * static_cast<int>(i);
    if (before.closed && !after.closed) log_.add({t, first, false});
    if (!before.closed || !after.closed) continue;
    for (int k = 0; k < contact_groups; ++k) {
      const auto group = static_cast<std::size_t>(k);
      const bool reverses = after.groups[group].moves && before.groups[group].moves &&
                            after.groups[group].direction.dot(before.groups[group].direction) < 0;
      if (reverses || after.groups[group].moves != before.groups[group].moves)
        log_.add({t, first + 1 + k, after.groups[group].moves});
    }
  }
}

// What is closed does not approach, and what is at rest, or begins to move from there, does not move.
void TouchModes::finish(double* y) {
  std::ranges::fill(triggered_, Trigger{});
  if (!locks_.empty()) locks_.finish(y);
  if (touch_.closed().empty()) return;
  double* const v = y + mechanism_.nq;
  const double rest = slow(v);
  go_to(y);
  const std::vector<SpotMode> modes = touch_.modes();
  std::vector<SpotMode> stopped = modes;
  TouchEquations::Rows rows;
  touch_.build(touch_.closed(), modes, false, rows);
  for (const TouchEquations::Entry& entry : rows.entries) {
    for (std::size_t k = 0; k < contact_groups; ++k) {
      bool& moves = stopped[static_cast<std::size_t>(entry.spot)].groups[k].moves;
      moves = moves && entry.slip[k].norm() > rest;
    }
  }
  touch_.set_modes(stopped);
  touch_.close_velocity(v);
  touch_.set_modes(modes);
}

}  // namespace gelenk
