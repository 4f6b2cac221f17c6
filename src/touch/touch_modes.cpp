// SPDX-License-Identifier: BSD-3-Clause
#include "touch/touch_modes.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "contact/contact_finder.h"
#include "contact/step_limits.h"
#include "kinematics/loads.h"

namespace gelenk {
namespace {

using Eigen::Map;
using Eigen::VectorXd;

// A normal force or a force of friction beyond its bound by less than this fraction of the normal forces is rounding.
constexpr double force_rounding = 1e-11;
// A gap up to this fraction of what counts as contact has been reached.
constexpr double reached_fraction = 1e-2;
// Gaps beyond the held mode by less than this are rounding.
constexpr double watched_depth = touch_tolerance;

}  // namespace

TouchModes::TouchModes(const Context& context)
    : mechanism_(context.mechanism),
      dynamics_(context.dynamics),
      equations_(context.equations),
      log_(context.log),
      first_indicator_(context.first_indicator),
      touch_(context.mechanism, context.dynamics, context.loads),
      locks_(context.locks, context.mechanism.nv),
      hidden_(context.mechanism, context.dynamics, touch_),
      decision_(touch_),
      outputs_(context.mechanism, context.dynamics, touch_, context.loads.contacts.size()),
      triggered_(touch_.modes().size()),
      vdot_(static_cast<std::size_t>(context.mechanism.nv)),
      checked_(static_cast<std::size_t>(indicators())),
      checked_rates_(checked_.size()),
      expected_(std::make_unique<bool[]>(checked_.size())) {
  for (int i = 0; i < touch_.spots().count(); ++i) {
    const Spot& spot = touch_.spots()[i];
    if (spot.kind != Spot::Kind::corner && spot.kind != Spot::Kind::edges) continue;
    if (std::ranges::find(guards_, spot.contact, &Guard::contact) == guards_.end())
      guards_.push_back({.contact = spot.contact, .spot = i});
  }
}

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
  touch_.set_modes(std::vector<SpotMode>(triggered_.size()));
  started_ = true;
  for (Guard& guard : guards_) guard.least = INFINITY;
  refusal_.clear();
}

void TouchModes::indicator_values(double t, const double* y, double* g, double* gdot) {
  const int n = touch_.spots().count();
  std::fill_n(g, per_spot * n, -1.0);
  std::fill_n(gdot, per_spot * n, 0.0);
  if (!touch_.closed().empty()) {
    equations_.touched_accelerations(t, y, vdot_.data());
    indicators_of_closed(g, gdot);
  }
  go_to(y);
  for (int i = 0; i < n; ++i) {
    if (mode_of(i).closed) continue;
    const auto first = static_cast<std::size_t>(per_spot) * static_cast<std::size_t>(i);
    g[first] = -touch_.spots()[i].size;
    if (!touch_.spots().is_close(i)) {
      if (!touch_.spots().shows_distance(i)) continue;
      g[first] = -touch_.spots().distance(i, gdot[first]);
      gdot[first] = -gdot[first];
      continue;
    }
    if (!touch_.spots().is_near(i)) continue;
    const SpotState at = touch_.spots().state(i);
    g[first] = -at.gap - mode_of(i).leaves_from;
    gdot[first] = -at.rate;
  }
  find_penetration(g);
}

// Shows in the indicators g what penetrates although no feature touches. The position is that of `dynamics`.
void TouchModes::find_penetration(double* g) {
  for (const Guard& guard : guards_) {
    const bool any_closed =
        std::ranges::any_of(touch_.closed(), [&](int spot) { return touch_.spots()[spot].contact == guard.contact; });
    if (any_closed || !(guard.allowed < INFINITY)) continue;
    const double depth = -outputs_.gap(guard.contact);
    double& value = g[static_cast<std::ptrdiff_t>(per_spot) * guard.spot];
    if (depth > guard.allowed) value = std::max(value, depth);
  }
}

void TouchModes::redistribute(double t, const double* y, double* locks, double* own) {
  redistributed_ = false;
  if (touch_.closed().empty()) return;
  std::vector<double*> yielding;
  find_yielding(own, yielding);
  std::size_t kept = touch_.closed().size();
  if (locks != nullptr) kept += locks_.find_yielding(locks, yielding);
  // A single contact has redundant forces where its body cannot move in all directions, as on a pendulum.
  const bool may_differ = kept > 1 || !touch_.are_unique();
  if (yielding.empty() || !may_differ || !holds_by_others(t, y)) return;
  redistributed_ = true;
  for (double* value : yielding) *value = *value > 0 ? -*value : std::max(-*value, std::numeric_limits<double>::min());
}

// Of the indicators g, those that say that a contact gives way in which something is kept at rest.
void TouchModes::find_yielding(double* g, std::vector<double*>& out) const {
  for (const int spot : touch_.closed()) {
    double* const of = g + static_cast<std::ptrdiff_t>(per_spot) * spot;
    if (!(of[0] > 0)) out.push_back(of);
    for (std::size_t k = 0; k < contact_groups; ++k) {
      if (of[1 + k] > 0 && !mode_of(spot).groups[k].moves) out.push_back(of + 1 + k);
    }
  }
}

void TouchModes::indicators_of_closed(double* g, double* gdot) {
  const auto& forces = touch_.forces();
  double sum = 0;
  for (const auto& force : forces) sum += std::abs(force.normal);
  const double slack = force_rounding * sum;
  const Map<const VectorXd> vdot(vdot_.data(), mechanism_.nv);
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const TouchEquations::Entry& entry = touch_.rows().entries[i];
    double* const of = g + static_cast<std::ptrdiff_t>(per_spot) * entry.spot;
    double* const rate = gdot + static_cast<std::ptrdiff_t>(per_spot) * entry.spot;
    of[0] = forces[i].normal + slack;
    of[per_spot - 1] = touch_.spots().margin(entry.spot) + touch_tolerance;
    rate[0] = rate[per_spot - 1] = NAN;
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

// Whether everything that is kept at rest can remain so, by any distribution of redundant forces.
bool TouchModes::holds_by_others(double t, const double* y) {
  const std::vector<SpotMode> present = touch_.modes();
  const LockModes::State present_locks = locks_.state();
  const std::vector<int> spots(touch_.closed().begin(), touch_.closed().end());
  touch_.set_modes(std::vector<SpotMode>(present.size()));
  locks_.begin_check();
  equations_.touched_accelerations(t, y, vdot_.data());
  std::vector<SpotMode> next = present;
  set_accelerations(t, y);
  const auto outcome =
      decision_.decide(spots, std::vector<Trigger>(present.size()), vdot_.data(), next, locks_.problem());
  touch_.set_modes(present);
  locks_.set_state(present_locks);
  bool holds = outcome == ContactDecision::Outcome::found;
  for (const int spot : spots) {
    const auto i = static_cast<std::size_t>(spot);
    holds = holds && next[i].closed;
    for (std::size_t k = 0; k < contact_groups; ++k)
      holds = holds && (present[i].groups[k].moves || !next[i].groups[k].moves);
  }
  return holds && std::ranges::none_of(locks_.problem().locks, &LockProblem::Lock::leaves);
}

// Whether forces of the last accelerations are outside the laws of what is kept at rest.
bool TouchModes::exceed_laws() {
  if (locks_.exceed_limits()) return true;
  indicators_of_closed(checked_.data(), checked_rates_.data());
  std::vector<double*> yielding;
  find_yielding(checked_.data(), yielding);
  return !yielding.empty();
}

void TouchModes::record_outputs(double t, const double* y) {
  if (!touch_.closed().empty() && exceed_laws() && holds_by_others(t, y)) {
    const VectorXd distributed = decision_.contact_forces();
    equations_.touched_accelerations(t, y, vdot_.data());
    outputs_.record(&distributed);
  } else {
    outputs_.record(nullptr);
  }
  outputs_.open_all();
}

// Of the problem of locks.
void TouchModes::set_accelerations(double t, const double* y) {
  locks_.problem().accelerate = [this, t, y](double* vdot) {
    dynamics_.set_position(y);
    locks_.try_answers();
    equations_.touched_accelerations(t, y, vdot);
    locks_.read_forces();
  };
}

void TouchModes::remembered_mode(bool* positive) const {
  for (int i = 0; i < touch_.spots().count(); ++i) {
    const SpotMode& mode = mode_of(i);
    bool* const of = positive + static_cast<std::ptrdiff_t>(per_spot) * i;
    of[0] = of[per_spot - 1] = mode.closed;
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
    if (!touch_.spots().is_close(i) || mode_of(i).closed) continue;
    if (touch_.spots().gap(i) >= -watched_depth - mode_of(i).leaves_from || !touch_.spots().is_near(i)) continue;
    mode_exit_time_ = t;
    return;
  }
}

void TouchModes::found_event(double, int indicator, bool positive) {
  Trigger& trigger = triggered_[static_cast<std::size_t>(indicator / per_spot)];
  const int which = indicator % per_spot;
  if (which == per_spot - 1) {
    trigger.ends = true;
  } else if (which > 0) {
    trigger.groups[static_cast<std::size_t>(which - 1)] = true;
  } else {
    (positive ? trigger.touches : trigger.leaves) = true;
  }
}

void TouchModes::change_mode(double t, double* y) {
  if (locks_.is_triggered() || std::ranges::any_of(triggered_, &Trigger::any)) determine(t, y);
}

// Impulses, and the modes that follow.
void TouchModes::determine(double t, double* y) {
  const std::vector<SpotMode> before = touch_.modes();
  const LockModes::State locks_before = locks_.state();
  strike(t, y, {}, locks_before);
  if (!decide(t, y, Recording::doubts) && locks_.is_triggered()) locks_.force_away(t);
  refuse_ends(t);
  finish(y);
  // Of joints; what contacts throw off so slowly is decided on with the accelerations (lasting).
  std::vector<int> stopped;
  for (int attempt = 0; attempt < JointLocks::most_returns && !locks_.empty(); ++attempt) {
    const std::vector<int> returning = locks_.find_returning(t, y, locks_before, stopped);
    if (returning.empty()) break;
    strike(t, y, returning, locks_before);
    decide(t, y, Recording::doubts);
    finish(y);
  }
  if (!locks_.empty()) locks_.record_changes(t, locks_before);
  record_changes(t, before);
}

// Cylinders on their flat ends have no points of contact that remain when they tilt.
void TouchModes::refuse_ends(double t) {
  for (int i = 0; i < touch_.spots().count(); ++i) {
    if (touch_.spots()[i].kind != Spot::Kind::rim) continue;
    const bool touches = mode_of(i).closed || touch_.spots().gap(i) <= touch_tolerance;
    const bool ends = triggered_[static_cast<std::size_t>(i)].ends || touch_.spots().margin(i) <= 0;
    if (!touches || !ends) continue;
    refusal_ = log_.report({t, first_indicator_ + per_spot * i, true}).text +
               " with a flat end, whose contacts are not located: use the integrator moreau-jean";
  }
}

// Whether a spot touches, as far as its gap says.
bool TouchModes::may_touch(int spot) const {
  return touch_.spots().is_close(spot) && touch_.spots().gap(spot) <= touch_tolerance && touch_.spots().is_near(spot);
}

// Brings directions and distances up to the state where a step begins; returns whether something touches that was not
// located.
bool TouchModes::update_modes(double t, const double* y) {
  const double rest = slow(y + mechanism_.nq);
  std::vector<SpotMode>& next = updated_;
  next = touch_.modes();
  go_to(y);
  bool touches = false;
  for (int i = 0; i < touch_.spots().count(); ++i) {
    SpotMode& mode = next[static_cast<std::size_t>(i)];
    if (mode.closed) continue;
    if (!may_touch(i)) {
      mode.leaves_from = 0;
      continue;
    }
    const SpotState at = touch_.spots().state(i);
    touches = touches || (mode.leaves_from == 0 && at.gap <= reached_fraction * touch_tolerance && at.rate < -rest);
  }
  if (!touch_.closed().empty()) {
    touch_.build(touch_.closed(), touch_.modes(), true, updated_rows_);
    for (const TouchEquations::Entry& entry : updated_rows_.entries) {
      for (std::size_t k = 0; k < contact_groups; ++k) {
        SpotMode::Group& group = next[static_cast<std::size_t>(entry.spot)].groups[k];
        const double speed = entry.slip[k].norm();
        if (group.moves && speed > rest) group.direction = entry.slip[k] / speed;
      }
    }
  }
  touch_.set_modes(next);
  update_guards(t);
  hidden_.begin();
  return touches;
}

// Refuses what has come to overlap although nothing was found to touch.
void TouchModes::update_guards(double t) {
  for (Guard& guard : guards_) {
    const double depth = std::max(0.0, -outputs_.gap(guard.contact));
    guard.allowed = depth + watched_depth;
    guard.least = std::min(guard.least, depth);
    if (depth <= guard.least + TouchOutputs::least_overlap) continue;
    const std::string event = log_.report({t, first_indicator_ + per_spot * guard.spot, true}).text;
    refusal_ = event.substr(0, event.rfind(": ")) +
               ": shapes overlap, but where they came into contact was not found: use the integrator auto, or a "
               "smaller tolerance";
  }
}

// Whether the present modes obey the laws at (t, y).
bool TouchModes::is_consistent(double t, const double* y) {
  std::vector<double>& g = checked_;
  remembered_mode(expected_.get());
  indicator_values(t, y, g.data(), checked_rates_.data());
  redistribute(t, y, nullptr, g.data());
  for (const int spot : touch_.closed()) {
    for (int k = 0; k < per_spot; ++k) {
      const std::size_t i =
          static_cast<std::size_t>(per_spot) * static_cast<std::size_t>(spot) + static_cast<std::size_t>(k);
      if ((g[i] > 0) != expected_[i]) return false;
    }
  }
  for (int i = 0; i < touch_.spots().count(); ++i) {
    if (!mode_of(i).closed && may_touch(i)) return false;
  }
  return true;
}

bool TouchModes::recall_mode(double t, double* y) {
  const bool touches = update_modes(t, y);
  const bool decides = locks_.recall(t, y) || touches || started_ || (jumped_ && !is_consistent(t, y));
  started_ = jumped_ = false;
  if (!decides) return false;
  determine(t, y);
  go_to(y);
  hidden_.begin();
  return true;
}

void TouchModes::preview(double t, const double* y) {
  const bool settled = !started_ && (!jumped_ || (is_consistent(t, y) && !locks_.are_doubtful(t, y)));
  if (settled) return;
  decide(t, y, Recording::nothing);
}

void TouchModes::serialize(Archive& archive) {
  std::vector<SpotMode>& modes = updated_;  // steps allocate no memory
  modes = touch_.modes();
  for (SpotMode& mode : modes) {
    archive.serialize(mode.closed, mode.leaves_from);
    for (SpotMode::Group& group : mode.groups) {
      archive.serialize(group.moves, group.direction.x(), group.direction.y(), group.direction.z());
    }
  }
  archive.serialize(started_, jumped_, counts_.impacts, counts_.closed_series, counts_.ambiguous);
  for (Guard& guard : guards_) archive.serialize(guard.allowed, guard.least);
  if (!archive.reading()) return;
  touch_.set_modes(modes);
  std::ranges::fill(triggered_, Trigger{});
  refusal_.clear();
}

}  // namespace gelenk
