// SPDX-License-Identifier: BSD-3-Clause
// What follows when coordinates come to rest, strike a bound, or are let go: the part of LockModes that decides.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "event/lost_rebound.h"
#include "kinematics/branches.h"
#include "linear/box_complementarity.h"
#include "modes/lock_modes.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Where friction at rest reaches its limit, everything slips whose limit is used up to this fraction, so that what
// breaks away at the same instant does so together.
constexpr double break_away_fraction = 1e-9;
constexpr double shared_fraction = 1e-8;  // the same with the rounding of distributed forces
// Relative tolerance of accelerations, less than the slack of holding forces (Branching::slack).
constexpr double acceleration_tolerance = 1e-11;
// Slip that an impact causes and friction stops within this is none [natural units]: the rounding of positions, as of
// rebounds.
constexpr double shortest_slip = 2e-12;
// Decisions where limits depend on loads, and the relative change of limits at which they are repeated no more.
constexpr int most_decisions = 60;
constexpr double load_tolerance = 1e-13;

}  // namespace

// Records how the modes differ from those before.
void LockModes::record_changes(double t, const State& before) {
  for (int i = 0; i < count(); ++i) {
    const Branching::Lock lock = forces_.lock(i);
    const int motion = modes_.motions[i];
    if (lock.friction >= 0 && motion != before.motions[i]) {
      const int direction = motion != 0 ? motion : before.motions[i];
      log_.add({t, 2 * lock.friction + (direction < 0 ? 1 : 0), motion != 0});
    }
    if (before.contacts[i] != 0 && modes_.contacts[i] == 0) {
      log_.add({t, limit_indicator(i, before.contacts[i]), false});
    }
    if (lock.one_way && before.contacts[i] == 0 && modes_.contacts[i] != 0)
      log_.add({t, limit_indicator(i, modes_.contacts[i]), true});
  }
}

// Whether the loads of meshes have other signs than at the last call, or are not known.
bool LockModes::load_signs_changed() {
  constexpr char unknown = 2;
  const auto count = static_cast<std::size_t>(forces_.loads().signed_count());
  load_indicators_.resize(count);
  load_signs_.resize(count, unknown);
  forces_.loads().indicators(load_indicators_.data());
  bool changed = false;
  for (std::size_t i = 0; i < count; ++i) {
    const char sign = load_indicators_[i] > 0 ? 1 : 0;
    changed = changed || sign != load_signs_[i];
    load_signs_[i] = sign;
  }
  return changed;
}

// Where friction of a mesh in motion depends so much on its load that no motion agrees with it, as where a load
// decelerates a self-locking gear, the load rises without limit, and the motion stops at once: an impact without a
// collision (Painleve 1895; Le Suan An 1990). The impulses that stop it agree with the law of the mesh. Returns whether
// there is such a friction.
bool LockModes::seize(double t, double* y) {
  equations_.accelerations_at(t, y, vdot_.data());
  const int force = forces_.loads().seized();
  if (force < 0) return false;
  const State before = state();
  const int lock = lock_of_[static_cast<std::size_t>(force)];
  triggered_[lock] = by_friction;
  strike(t, y, {lock}, before);
  settle(t, y, false, Recording::doubts);
  finish_change(y);
  record_changes(t, before);
  return true;
}

// Lets go what is no longer held where rounding hides it, and what is at its limit, too: one alone could not move.
void LockModes::force_away(double t) {
  State next = state();
  for (int i = 0; i < count(); ++i) {
    if (!rests(i) || (triggered_[i] == nothing && !uses_limit_up(i))) continue;
    next.motions[i] = modes_.contacts[i] != 0 ? -modes_.contacts[i] : holding_[i] > 0 ? -1 : 1;
    next.contacts[i] = 0;
    next.leaves_from[i] = leaving_depth(i);
    if (!has_friction(i)) next.motions[i] = branch_released;
  }
  enter(t, next, Recording::doubts);
}

// Whether friction at rest is at its limit, within what distributed forces are in error.
bool LockModes::uses_limit_up(int lock) const {
  const double holding = holding_[static_cast<std::size_t>(lock)];
  const double limit = forces_.lock(lock).sticking_limit.against(holding > 0 ? -1 : 1);
  return modes_.contacts[lock] == 0 && limit > 0 && std::abs(holding) >= (1 - shared_fraction) * limit;
}

// Impacts: the impulses of all contacts together. returning: locks that stop as well. before: the modes before all that
// happens at this instant.
void LockModes::strike(double t, double* y, const std::vector<int>& returning, const State& before) {
  double* v = y + nq_;
  dynamics_.set_position(y);
  std::vector<int> struck;
  std::vector<StruckContact> contacts;
  for (int i = 0; i < count(); ++i) {
    const Branching::Lock lock = forces_.lock(i);
    const int side = lock.limit < 0 ? 0 : touched_side(i);
    const bool returns = std::ranges::find(returning, i) != returning.end();
    if (side == 0 && !returns) continue;
    struck.push_back(i);
    contacts.push_back({side, forces_.speed(i, v), returns ? 0 : lock.restitution, lock.poisson, returns});
  }
  std::vector<int> met;
  for (std::size_t i = 0; i < struck.size(); ++i) {
    const StruckContact& at = contacts[i];
    const bool approaches = at.side * at.speed > 0 && !is_slow(struck[i], v);
    if (approaches || (at.held && at.side != 0 && before.contacts[struck[i]] == 0)) met.push_back(static_cast<int>(i));
  }
  if (met.empty() && returning.empty()) return;
  equations_.accelerations_at(t, y, vdot_.data());
  Eigen::MatrixXd W;
  VectorXd scale;
  forces_.compliance(struck, W, scale);
  const Impact impact = solve_impact_without_series(W, v, struck, contacts);
  if (!impact.found) ++counts_.ambiguous;
  for (const int i : met) record_impact(t, struck[i], contacts[i].side, impact);
  forces_.strike(struck, impact.impulses, v);
  for (int i = 0; i < count(); ++i) {
    if (!is_slow(i, v)) triggered_[i] = nothing;
  }
  for (const int lock : struck) modes_.leaves_from[lock] = modes_.contacts[lock] == 0 ? leaving_depth(lock) : 0;
  equations_.mode_changed();
}

void LockModes::record_impact(double t, int lock, int side, const Impact& impact) {
  ++counts_.impacts;
  const int indicator = limit_indicator(lock, side);
  if (!forces_.lock(lock).one_way) log_.add({t, indicator, true, !impact.found});
  if (!impact.is_possible) modes_.unstoppable = indicator;
}

// Contacts of which the rebound would be lost in rounding have no restitution, and what others throw off so slowly
// stays in contact: it would return, throw them off, and so on.
Impact LockModes::solve_impact_without_series(const Eigen::MatrixXd& W, const double* v, const std::vector<int>& struck,
                                              std::vector<StruckContact>& contacts) {
  Impact impact;
  for (bool closed = true; closed;) {
    closed = false;
    impact = solve_impact(W, contacts);
    const VectorXd changes = W * impact.impulses;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      StruckContact& contact = contacts[i];
      const auto at = static_cast<Index>(i);
      const double rebound = -contact.side * (contact.speed + changes[at]);
      if (contact.held || !(rebound > 0) || !ends_series(struck[i], contact.side, rebound, W(at, at), 0)) continue;
      contact.held = contact.restitution == 0;
      contact.restitution = 0;
      closed = true;
      if (contact.side * contact.speed > 0 && !is_slow(struck[i], v)) ++counts_.closed_series;
    }
  }
  return impact;
}

// Whether a coordinate that something has set in motion at this instant comes to rest again before the motion matters,
// with the accelerations vdot_: one that has left a bound that it touches still, and returns to it; one that friction
// stops. Of what rebounds by its own restitution, only rounding does not matter, so that the end of a series of impacts
// does not depend on tolerances.
bool LockModes::returns(int lock, const State& before, const double* v) const {
  if (is_slow(lock, v)) return false;
  const double speed = forces_.speed(lock, v);
  const Branching::Lock of = forces_.lock(lock);
  const int side = modes_.contacts[lock] == 0 && modes_.leaves_from[lock] != 0 ? touched_side(lock) : 0;
  if (side != 0) {
    const bool rebounds = of.restitution > 0 && before.contacts[lock] == 0;
    if (ends_series(lock, side, speed, 0, rebounds ? 0 : resolution_)) return true;
  }
  if (of.friction < 0 || !before.rests(lock) || rests(lock)) return false;
  const double deceleration = (speed > 0 ? -1 : 1) * forces_.speed(lock, vdot_.data());
  return deceleration > 0 && speed * speed <= 2 * deceleration * std::max(resolution_, shortest_slip);
}

// What is returning. stopped: what friction has stopped in the same way at this instant, which stays at rest; brought
// up to date.
std::vector<int> LockModes::find_returning(double t, const double* y, const State& before, std::vector<int>& stopped) {
  const double* v = y + nq_;
  std::vector<int> out;
  dynamics_.set_position(y);
  for (int i = 0; i < count(); ++i) {
    const bool left = modes_.leaves_from[i] != 0 && modes_.contacts[i] == 0 && touched_side(i) != 0;
    const bool slips = has_friction(i) && !rests(i) && before.rests(i);
    if (left || slips) out.push_back(i);
  }
  if (out.empty()) return out;
  equations_.accelerations_at(t, y, vdot_.data());
  std::erase_if(out, [&](int i) { return !returns(i, before, v); });
  if (out.empty()) return out;
  for (const int lock : out) {
    if (touched_side(lock) != 0) triggered_[lock] = by_limit;
  }
  std::erase_if(stopped, [&](int lock) { return !rests(lock); });
  out.insert(out.end(), stopped.begin(), stopped.end());
  std::ranges::sort(out);
  stopped.clear();
  std::ranges::copy_if(out, std::back_inserter(stopped), [&](int lock) { return has_friction(lock); });
  return out;
}

// Brings what is returning to rest. Its impulses may let go what has come to rest before.
void LockModes::close_returning(double t, double* y, const State& before) {
  std::vector<int> stopped;
  for (int attempt = 0; attempt < most_returns; ++attempt) {
    const std::vector<int> locks = find_returning(t, y, before, stopped);
    if (locks.empty()) return;
    strike(t, y, locks, before);
    settle(t, y, false, Recording::doubts);
    finish_change(y);
  }
}

// Whether a rebound with this speed would be lost in rounding, or not be higher than the resolution, and more would
// follow. `dynamics` and vdot_ are those at the impact; mobility: the acceleration per force.
bool LockModes::ends_series(int lock, int side, double speed, double mobility, double resolution) const {
  if (forces_.lock(lock).one_way) return false;
  const double holding = forces_.holding_forces().values()[static_cast<std::size_t>(lock)];
  const double acceleration =
      modes_.contacts[lock] != 0 ? -side * holding * mobility : side * forces_.speed(lock, vdot_.data());
  const Branching::Depth at = forces_.depth(lock, side);
  return rises_no_higher(std::max(resolution, lowest_rebound * at.tolerance), speed, acceleration);
}

// Determines the modes at (t, y). What moves keeps moving; of what rests, friction and contact hold what they can, and
// the accelerations decide on the others. breaks_away: a force has reached its bound. Returns whether a mode has
// changed.
bool LockModes::settle(double t, const double* y, bool breaks_away, Recording records) {
  const State before = state();
  const double* v = y + nq_;
  State next = before;
  std::vector<int> undecided;
  dynamics_.set_position(y);
  for (int i = 0; i < count(); ++i) {
    const bool slow = is_slow(i, v) || triggered_[i] != nothing;
    next.contacts[i] = slow ? touched_side(i) : 0;
    const double speed = forces_.speed(i, v);
    next.motions[i] = slow || !has_friction(i) ? branch_released : speed > 0 ? 1 : -1;
    if (slow && (has_friction(i) || next.contacts[i] != 0)) undecided.push_back(i);
  }
  if (!undecided.empty()) {
    if (!forces_.loads().empty()) {
      decide_with_loads(next, undecided, breaks_away, t, y);
    } else {
      decide_at(next, undecided, breaks_away, t, y);
    }
  }
  record_doubtful(t, records != Recording::nothing);
  enter(t, next, records);
  return state() != before;
}

// next: as in decide(). Enters the present modes again.
void LockModes::decide_at(State& next, const std::vector<int>& undecided, bool breaks_away, double t, const double* y) {
  const State before = state();
  const std::vector<int> contacts = std::move(next.contacts);
  next.contacts.assign(contacts.size(), 0);
  set_state(next);
  equations_.accelerations_at(t, y, vdot_.data());
  next.contacts = contacts;
  set_state(before);
  decide(next, undecided, breaks_away);
}

// The limits of friction depend on the modes that they decide on: the decision is repeated with the limits in the modes
// decided on, until both agree. It begins with everything at rest, since what can remain at rest does.
void LockModes::decide_with_loads(State& next, const std::vector<int>& undecided, bool breaks_away, double t,
                                  const double* y) {
  const State before = state();
  const State open = next;
  const auto limits = [&] {
    VectorXd out(2 * static_cast<Index>(undecided.size()));
    for (Index i = 0; i < out.size() / 2; ++i) {
      const DirectedLimit limit = forces_.lock(undecided[static_cast<std::size_t>(i)]).sticking_limit;
      out[2 * i] = limit.positive;
      out[2 * i + 1] = limit.negative;
    }
    return out;
  };
  for (const int lock : undecided) {
    if (has_friction(lock)) next.motions[lock] = 0;
  }
  VectorXd known = VectorXd::Zero(2 * static_cast<Index>(undecided.size()));
  bool agree = false;
  for (int round = 0; round < most_decisions && !agree; ++round) {
    doubtful_.clear();
    const State decided = next;
    set_state(next);
    find_holding_forces(t, y);
    const VectorXd now = limits();
    forces_.loads().freeze(true);
    set_state(before);
    next = open;
    decide_at(next, undecided, breaks_away, t, y);
    forces_.loads().freeze(false);
    agree = next == decided && (now - known).cwiseAbs().maxCoeff() <= load_tolerance * now.cwiseAbs().maxCoeff();
    known = now;
  }
  if (!agree) doubtful_.insert(doubtful_.end(), undecided.begin(), undecided.end());
}

// logs: a preview is without effect on the run.
void LockModes::record_doubtful(double t, bool logs) {
  for (const int lock : doubtful_) {
    if (!logs) break;
    ++counts_.ambiguous;
    const int friction = forces_.lock(lock).friction;
    log_.add({t, 2 * (friction >= 0 ? friction : forces_.lock(lock).limit), friction < 0, true});
  }
  doubtful_.clear();
}

// next: in, the contacts that are possible; out, the modes of the undecided coordinates. vdot_: their accelerations
// when all are released.
void LockModes::decide(State& next, const std::vector<int>& undecided, bool breaks_away) {
  Eigen::MatrixXd W;
  VectorXd scale;
  forces_.compliance(undecided, W, scale);
  HoldingBounds bounds = holding_bounds(forces_, undecided, next.contacts);
  const auto n = static_cast<Index>(undecided.size());
  VectorXd b(n);
  VectorXd limits(n);
  const auto limit_to = [&](Index i, const DirectedLimit& limit, double part) {
    limits[i] = part * limit.largest();
    if (std::isfinite(bounds.lower[i])) bounds.lower[i] = -part * limit.against(1);
    if (std::isfinite(bounds.upper[i])) bounds.upper[i] = part * limit.against(-1);
  };
  for (Index i = 0; i < n; ++i) {
    b[i] = -forces_.speed(undecided[i], vdot_.data());
    limit_to(i, forces_.lock(undecided[i]).sticking_limit, breaks_away ? 1 - break_away_fraction : 1);
  }
  scale = scale.cwiseMax(W.cwiseAbs() * limits);
  std::vector<char> leaves(undecided.size(), 0);
  BoxSolution found;
  const auto is_held = [&](Index i) {
    return found.at_bound[i] == 0 || std::abs(found.r[i]) <= acceleration_tolerance * scale[i];
  };
  for (bool changed = true; changed;) {
    changed = false;
    found = solve_in_box(W, b, bounds.lower, bounds.upper);
    for (Index i = 0; i < n; ++i) {
      if (leaves[i] != 0 || is_held(i)) continue;
      leaves[i] = 1;
      const DirectedLimit slipping = forces_.lock(undecided[i]).slipping_limit;
      if (!(limits[i] > slipping.largest())) continue;
      limit_to(i, slipping, 1);
      changed = true;
    }
  }
  if (!found.found) next.unstoppable = unstoppable_among(undecided, found, bounds, scale);
  for (Index i = 0; i < n; ++i) take_up(next, undecided[i], leaves[i] != 0, -found.at_bound[i]);
}

// After a problem without a solution: a motion against a contact that constraint equations determine.
int LockModes::unstoppable_among(const std::vector<int>& locks, const BoxSolution& found, const HoldingBounds& bounds,
                                 const VectorXd& scale) const {
  for (Index i = 0; i < found.r.size(); ++i) {
    const int side = found.r[i] > 0 ? -1 : 1;
    if (std::isfinite(side < 0 ? bounds.upper[i] : bounds.lower[i])) continue;
    // Rounding; and what remains in contact for a second.
    const double negligible = forces_.depth(locks[i], side).tolerance;
    if (std::abs(found.r[i]) > std::max(acceleration_tolerance * scale[i], negligible))
      return limit_indicator(locks[i], side);
  }
  return -1;
}

// leaves: whether the coordinate does not remain at rest; direction: of the motion that begins, which forces oppose, or
// to which the force is at its bound.
void LockModes::take_up(State& next, int lock, bool leaves, int direction) {
  if (leaves && direction != 0) {
    next.motions[lock] = has_friction(lock) ? direction : branch_released;
    next.contacts[lock] = 0;
    next.leaves_from[lock] = leaving_depth(lock);
    return;
  }
  if (leaves) doubtful_.push_back(lock);
  if (!has_friction(lock)) return;
  const bool keeps =
      direction != 0 && direction == modes_.motions[lock] && triggered_[lock] == nothing && next.contacts[lock] == 0;
  next.motions[lock] = keeps ? modes_.motions[lock] : 0;
}

}  // namespace gelenk
