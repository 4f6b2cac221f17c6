// SPDX-License-Identifier: BSD-3-Clause
// What follows where contacts are struck or let go: the part of TouchModes that decides.
#include <algorithm>
#include <utility>

#include "contact/contact_finder.h"
#include "touch/touch_modes.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// What leaves may be closer than touching by rounding, and go further by this fraction of what counts as contact before
// it touches again.
constexpr double leaving_fraction = 0.1;
// A series of impacts ends in contact when its rebounds are lower than this times what counts as contact.
constexpr double lowest_rebound = 2;

// Whether a rebound at this speed is lost in the rounding of the position, for this acceleration back.
bool is_lost(double speed, double acceleration) {
  return acceleration > 0 && speed * speed <= 2 * acceleration * lowest_rebound * touch_tolerance;
}

double leaving_depth(double gap) {
  return gap > touch_tolerance ? 0 : std::max(0.0, -gap) + leaving_fraction * touch_tolerance;
}

}  // namespace

// The impulses of all contacts that are struck.
void TouchModes::strike(double t, double* y) {
  double* const v = y + mechanism_.nq;
  const double rest = slow(v);
  go_to(y);
  std::vector<int> struck;
  bool any = false;
  for (int i = 0; i < touch_.spots().count(); ++i) {
    const SpotState at = touch_.spots().state(i);
    if (!mode_of(i).closed && at.gap > touch_tolerance) continue;
    struck.push_back(i);
    any = any || (at.rate < -rest && !mode_of(i).closed);
  }
  if (!any) return;
  const std::vector<SpotMode> present = touch_.modes();
  touch_.set_modes(std::vector<SpotMode>(present.size()));
  equations_.touched_accelerations(t, y, vdot_.data());
  ContactImpact impact(touch_, struck, v, rest);
  const bool found = impact.solve(decision_.solver());
  end_series(struck, impact, impact.approach());
  touch_.set_modes(present);
  if (!found) ++counts_.ambiguous;
  for (std::size_t i = 0; i < struck.size(); ++i) {
    if (!(impact.approach()[static_cast<Index>(i)] < -rest)) continue;
    ++counts_.impacts;
    log_.add({t, first_indicator_ + per_spot * struck[i], true, !found});
  }
  impact.apply(v);
  equations_.touch_changed();
}

// Contacts of which the rebound would be lost in rounding have no restitution.
void TouchModes::end_series(const std::vector<int>& struck, ContactImpact& impact, const VectorXd& approach) {
  for (bool closed = true; closed;) {
    closed = false;
    const VectorXd rebounds = impact.rebounds();
    const VectorXd falls = impact.accelerations(vdot_.data());
    for (std::size_t i = 0; i < struck.size(); ++i) {
      const auto at = static_cast<Index>(i);
      if (impact.restitution(i) == 0 || !(rebounds[at] > 0)) continue;
      if (!is_lost(rebounds[at], -falls[at])) continue;
      impact.set_inelastic(i);
      if (approach[at] < 0) ++counts_.closed_series;
      closed = true;
    }
    if (closed) impact.solve(decision_.solver());
  }
}

// The spots that touch and remain closed if forces keep them so, at the state of the last solve() with the
// accelerations vdot_: those with a normal velocity of zero, or one so low that they would return before they have left
// the rounding of their positions.
std::vector<int> TouchModes::lasting(double rest) {
  std::vector<int> touching;
  for (int i = 0; i < touch_.spots().count(); ++i) {
    if (touch_.spots().gap(i) <= touch_tolerance) touching.push_back(i);
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

// The modes that follow at (t, y). What moves keeps moving; on what is at rest accelerations decide.
void TouchModes::decide(double t, const double* y, bool logs) {
  const double rest = slow(y + mechanism_.nq);
  const std::vector<SpotMode> present = touch_.modes();
  std::vector<SpotMode> next(present.size());
  touch_.set_modes(next);
  equations_.touched_accelerations(t, y, vdot_.data());
  go_to(y);
  for (int i = 0; i < touch_.spots().count(); ++i)
    next[static_cast<std::size_t>(i)].leaves_from = leaving_depth(touch_.spots().gap(i));
  const std::vector<int> spots = lasting(rest);
  if (!spots.empty()) {
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
    const auto outcome = decision_.decide(spots, triggered_, vdot_.data(), next);
    if (outcome != ContactDecision::Outcome::found && logs) {
      ++counts_.ambiguous;
      log_.add({t, first_indicator_ + per_spot * spots.front(), true, true});
      if (outcome == ContactDecision::Outcome::none) {
        refusal_ = log_.report({t, first_indicator_ + per_spot * spots.front(), true}).text +
                   ", and no contact forces were found that agree with Coulomb's law (as in Painlev\u00e9's paradox)";
      }
    }
  }
  touch_.set_modes(present);
  enter(t, std::move(next), logs);
}

void TouchModes::enter(double t, std::vector<SpotMode> next, bool logs) {
  for (std::size_t i = 0; i < next.size(); ++i) {
    const SpotMode& before = touch_.modes()[i];
    SpotMode& after = next[i];
    if (after.closed) after.leaves_from = 0;
    if (!after.closed) after.groups = {};
    if (!logs) continue;
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
  const bool changed = next != touch_.modes();
  touch_.set_modes(next);
  if (changed && logs) equations_.touch_changed();
}

// What is closed does not approach, and what is at rest, or begins to move from there, does not move.
void TouchModes::finish(double* y) {
  std::ranges::fill(triggered_, Trigger{});
  if (!touch_.any_closed()) return;
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
