// SPDX-License-Identifier: BSD-3-Clause
#include "contact/touch_modes.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "contact/contact_finder.h"
#include "contact/step_limits.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

// A normal force or a force of friction beyond its bound by less than this fraction of the normal forces is rounding.
constexpr double force_rounding = 1e-11;
// What leaves may be closer than touching by rounding, and go further by this fraction of what counts as contact before
// it touches again; and a gap up to this fraction of it has been reached.
constexpr double leaving_fraction = 0.1;
constexpr double reached_fraction = 1e-2;
// A series of impacts ends in contact when its rebounds are lower than this times what counts as contact.
constexpr double lowest_rebound = 2;
// Gaps beyond the held mode by less than this are rounding.
constexpr double watched_depth = touch_tolerance;

// Whether a rebound at this speed is lost in the rounding of the position, for this acceleration back.
bool is_lost(double speed, double acceleration) {
  return acceleration > 0 && speed * speed <= 2 * acceleration * lowest_rebound * touch_tolerance;
}

double leaving_depth(double gap) {
  return gap > touch_tolerance ? 0 : std::max(0.0, -gap) + leaving_fraction * touch_tolerance;
}

}  // namespace

TouchModes::TouchModes(const Context& context)
    : mechanism_(context.mechanism),
      dynamics_(context.dynamics),
      equations_(context.equations),
      log_(context.log),
      first_indicator_(context.first_indicator),
      touch_(context.mechanism, context.dynamics, context.loads),
      decision_(touch_),
      before_(touch_.modes()),
      triggered_(before_.size()),
      vdot_(static_cast<std::size_t>(context.mechanism.nv)),
      sums_(context.loads.contacts.size()),
      wrenches_(context.mechanism.links.size()) {}

// Speeds up to this are rest.
double TouchModes::slow(const double* v) const {
  double fastest = 1;
  for (int k = 0; k < mechanism_.nv; ++k) fastest = std::max(fastest, std::abs(v[k]));
  return rest_speed * fastest;
}

void TouchModes::go_to(const double* y) {
  dynamics_.set_position(y);
  dynamics_.set_velocity(y + mechanism_.nq);
  touch_.spots().read_motion(dynamics_);
}

void TouchModes::start() {
  touch_.set_modes(std::vector<SpotMode>(before_.size()));
  started_ = true;
  refusal_.clear();
}

void TouchModes::indicator_values(double t, const double* y, double* g, double* gdot) {
  const int n = touch_.spots().count();
  std::fill_n(g, per_spot * n, -1.0);
  std::fill_n(gdot, per_spot * n, 0.0);
  if (touch_.any_closed()) {
    equations_.touched_accelerations(t, y, vdot_.data());
    indicators_of_closed(g, gdot);
    bool strained = false;
    for (const int spot : touch_.closed()) {
      for (int k = 1; k < per_spot; ++k) {
        const auto group = static_cast<std::size_t>(k - 1);
        strained = strained || (!mode_of(spot).groups[group].moves && g[per_spot * spot + k] > 0);
      }
    }
    // Redundant forces of friction may be distributed in other ways.
    if (strained && touch_.closed().size() > 1 && holds_by_others(t, y)) {
      for (const int spot : touch_.closed()) {
        for (int k = 1; k < per_spot; ++k) {
          double& value = g[per_spot * spot + k];
          if (!mode_of(spot).groups[static_cast<std::size_t>(k - 1)].moves) value = -std::abs(value);
        }
      }
    }
  }
  go_to(y);
  for (int i = 0; i < n; ++i) {
    if (mode_of(i).closed) continue;
    const SpotState at = touch_.spots().state(i);
    g[per_spot * i] = -at.gap - mode_of(i).leaves_from;
    gdot[per_spot * i] = -at.rate;
  }
}

void TouchModes::indicators_of_closed(double* g, double* gdot) {
  const auto& forces = touch_.forces();
  double sum = 0;
  for (const auto& force : forces) sum += std::abs(force.normal);
  const double slack = force_rounding * sum;
  const Eigen::Map<const VectorXd> vdot(vdot_.data(), mechanism_.nv);
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const TouchEquations::Entry& entry = touch_.rows().entries[i];
    double* const of = g + static_cast<std::ptrdiff_t>(per_spot) * entry.spot;
    double* const rate = gdot + static_cast<std::ptrdiff_t>(per_spot) * entry.spot;
    of[0] = forces[i].normal + slack;
    rate[0] = NAN;
    for (int group = 0; group < contact_groups; ++group) {
      const auto at = static_cast<std::size_t>(group);
      const SpotMode::Group& mode = mode_of(entry.spot).groups[at];
      if (entry.rows[at] < 0 && !mode.moves) continue;
      rate[1 + group] = NAN;
      if (!mode.moves) {
        of[1 + group] = forces[i].held[at] - touch_.coefficient(entry.spot, group, false) * forces[i].normal - slack;
        continue;
      }
      // Where the direction turns, this rate is that of the speed.
      const int row = entry.moving[at];
      const double cosine = entry.along[at].dot(mode.direction);
      of[1 + group] = entry.slip[at].dot(mode.direction);
      rate[1 + group] = cosine * (touch_.rows().S.row(row).dot(vdot) + touch_.rows().moving_rates[row]);
    }
  }
}

// Whether friction at rest can hold everything that it holds now, by any distribution of redundant forces.
bool TouchModes::holds_by_others(double t, const double* y) {
  const std::vector<SpotMode> present = touch_.modes();
  const std::vector<int> spots(touch_.closed().begin(), touch_.closed().end());
  touch_.set_modes(std::vector<SpotMode>(present.size()));
  equations_.touched_accelerations(t, y, vdot_.data());
  std::vector<SpotMode> next = present;
  const auto outcome = decision_.decide(spots, std::vector<Trigger>(present.size()), vdot_.data(), next);
  touch_.set_modes(present);
  bool holds = outcome == ContactDecision::Outcome::found;
  for (const int spot : spots) {
    const auto i = static_cast<std::size_t>(spot);
    for (std::size_t k = 0; k < contact_groups; ++k)
      holds = holds && (present[i].groups[k].moves || !next[i].closed || !next[i].groups[k].moves);
  }
  return holds;
}

void TouchModes::remembered_mode(bool* positive) const {
  for (int i = 0; i < touch_.spots().count(); ++i) {
    const SpotMode& mode = mode_of(i);
    bool* const of = positive + static_cast<std::ptrdiff_t>(per_spot) * i;
    of[0] = mode.closed;
    for (std::size_t k = 0; k < contact_groups; ++k) of[1 + k] = mode.closed && mode.groups[k].moves;
  }
}

void TouchModes::hold_mode(double t, const bool* positive) {
  held_ = positive != nullptr;
  held_from_ = t;
  mode_exit_time_ = INFINITY;
}

void TouchModes::check(double t) {
  touch_.spots().read_position(dynamics_);
  for (int i = 0; i < touch_.spots().count(); ++i) {
    if (mode_of(i).closed || touch_.spots().gap(i) >= -watched_depth - mode_of(i).leaves_from) continue;
    mode_exit_time_ = t;
    return;
  }
}

void TouchModes::found_event(double, int indicator, bool positive) {
  Trigger& trigger = triggered_[static_cast<std::size_t>(indicator / per_spot)];
  const int which = indicator % per_spot;
  if (which > 0) {
    trigger.groups[static_cast<std::size_t>(which - 1)] = true;
  } else {
    (positive ? trigger.touches : trigger.leaves) = true;
  }
}

void TouchModes::change_mode(double t, double* y) {
  if (std::ranges::none_of(triggered_, &Trigger::any)) return;
  strike(t, y);
  decide(t, y, true);
  finish(y);
}

// Brings directions and distances up to the state where a step begins; returns whether something touches that was not
// located.
bool TouchModes::update_modes(const double* y) {
  const double rest = slow(y + mechanism_.nq);
  std::vector<SpotMode> next = touch_.modes();
  go_to(y);
  bool touches = false;
  for (int i = 0; i < touch_.spots().count(); ++i) {
    SpotMode& mode = next[static_cast<std::size_t>(i)];
    if (mode.closed) continue;
    const SpotState at = touch_.spots().state(i);
    if (at.gap > touch_tolerance) mode.leaves_from = 0;
    if (mode.leaves_from == 0 && at.gap <= reached_fraction * touch_tolerance && at.rate < -rest) touches = true;
  }
  if (touch_.any_closed()) {
    TouchEquations::Rows rows;
    touch_.build(touch_.closed(), touch_.modes(), true, rows);
    for (const TouchEquations::Entry& entry : rows.entries) {
      for (std::size_t k = 0; k < contact_groups; ++k) {
        SpotMode::Group& group = next[static_cast<std::size_t>(entry.spot)].groups[k];
        const double speed = entry.slip[k].norm();
        if (group.moves && speed > rest) group.direction = entry.slip[k] / speed;
      }
    }
  }
  touch_.set_modes(next);
  return touches;
}

// Whether the present modes obey the laws at (t, y).
bool TouchModes::is_consistent(double t, const double* y) {
  std::vector<double> g(static_cast<std::size_t>(indicators()));
  std::vector<double> gdot(g.size());
  const auto expected = std::make_unique<bool[]>(g.size());
  remembered_mode(expected.get());
  indicator_values(t, y, g.data(), gdot.data());
  for (const int spot : touch_.closed()) {
    for (int k = 0; k < per_spot; ++k) {
      const auto i = static_cast<std::size_t>(per_spot * spot + k);
      if ((g[i] > 0) != expected[i]) return false;
    }
  }
  for (int i = 0; i < touch_.spots().count(); ++i) {
    if (!mode_of(i).closed && touch_.spots().gap(i) <= touch_tolerance) return false;
  }
  return true;
}

bool TouchModes::recall_mode(double t, double* y) {
  const bool touches = update_modes(y);
  const bool decides = touches || started_ || (jumped_ && !is_consistent(t, y));
  started_ = jumped_ = false;
  if (!decides) return false;
  strike(t, y);
  decide(t, y, true);
  finish(y);
  return true;
}

void TouchModes::preview(double t, const double* y) {
  if (!started_ && (!jumped_ || is_consistent(t, y))) return;
  decide(t, y, false);
}

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

void TouchModes::record_outputs() {
  std::ranges::fill(sums_, Sum{});
  std::ranges::fill(wrenches_, Spatial::Force{});
  const auto& forces = touch_.forces();
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const TouchEquations::Entry& entry = touch_.rows().entries[i];
    const Spot& spot = touch_.spots()[entry.spot];
    const Spatial::Force on_tip{forces[i].moment + entry.at.p.cross(forces[i].force), forces[i].force};
    wrenches_[static_cast<std::size_t>(spot.tip_link)] += on_tip;
    wrenches_[static_cast<std::size_t>(spot.core_link)] -= on_tip;
    Sum& sum = sums_[static_cast<std::size_t>(spot.contact)];
    sum.force -= spot.sign * (mechanism_.X_W0.R * forces[i].force);
    const bool slides = mode_of(entry.spot).groups[0].moves || !(touch_.coefficient(entry.spot, 0, false) > 0);
    sum.mode = std::max(sum.mode, slides ? 2 : 1);
  }
}

double TouchModes::gap(int contact) {
  touch_.spots().read_position(dynamics_);
  double out = std::numeric_limits<double>::infinity();
  for (int i = 0; i < touch_.spots().count(); ++i) {
    if (touch_.spots()[i].contact == contact) out = std::min(out, touch_.spots().gap(i));
  }
  return out;
}

std::vector<TouchModes::SpotName> TouchModes::names() const {
  std::vector<SpotName> out;
  for (int i = 0; i < touch_.spots().count(); ++i) {
    const Spot& spot = touch_.spots()[i];
    const auto body = [this](int shape) { return mechanism_.shapes[static_cast<std::size_t>(shape)].scene_body; };
    out.push_back({spot.contact, body(spot.tip), body(spot.core)});
  }
  return out;
}

std::array<std::array<std::string, 2>, TouchModes::per_spot> TouchModes::event_texts(const std::string& contact,
                                                                                     const std::string& tip,
                                                                                     const std::string& core) {
  const std::string subject = contact + ": " + tip;
  return {{{subject + " leaves " + core, subject + " touches " + core},
           {subject + " stops sliding on " + core, subject + " slides on " + core},
           {subject + " stops spinning on " + core, subject + " spins on " + core},
           {subject + " stops rolling on " + core, subject + " rolls on " + core}}};
}

void TouchModes::serialize(Archive& archive) {
  std::vector<SpotMode> modes = touch_.modes();
  for (SpotMode& mode : modes) {
    archive.serialize(mode.closed, mode.leaves_from);
    for (SpotMode::Group& group : mode.groups) {
      archive.serialize(group.moves, group.direction.x(), group.direction.y(), group.direction.z());
    }
  }
  archive.serialize(started_, jumped_, counts_.impacts, counts_.closed_series, counts_.ambiguous);
  if (archive.reading()) {
    touch_.set_modes(modes);
    refusal_.clear();
  }
}

}  // namespace gelenk
