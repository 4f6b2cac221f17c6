// SPDX-License-Identifier: BSD-3-Clause
#include "time_stepping/joint_rows.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "contact_geometry/contact_finder.h"
#include "math/bounds.h"
#include "time_stepping/step_limits.h"

namespace gelenk {
namespace {

// Part of the static friction from which on it is all of it, as the solver leaves it.
constexpr double at_bound = 1 - 1e-6;
// Speed that a projection may give, relative to that which a step without friction would: of the third order in the
// step, 2e-6 where a prescribed motion of 1.5 Hz is followed in steps of 1 ms.
constexpr double negligible_part = 3e-5;

// Limits as numbers, in the order in which set_limits() reads them.
void append(std::initializer_list<DirectedLimit> limits, std::vector<double>& out) {
  for (const DirectedLimit& limit : limits) out.insert(out.end(), {limit.positive, limit.negative});
}

}  // namespace

JointRows::JointRows(SwitchingForces& switching_forces, int nv)
    : switching_(switching_forces), beside_(static_cast<std::size_t>(switching_forces.locks()), -1) {
  std::vector<double> unit(static_cast<std::size_t>(nv));
  const auto are_same = [&](int a, int b) {
    return std::ranges::all_of(unit, [&](double& v) {
      v = 1;
      const bool same = switching_forces.speed(a, unit.data()) == switching_forces.speed(b, unit.data());
      v = 0;
      return same;
    });
  };
  for (int clutch = 0; clutch < switching_forces.locks(); ++clutch) {
    if (!switching_forces.lock(clutch).one_way) continue;
    for (int i = 0; i < switching_forces.locks(); ++i) {
      if (i != clutch && are_same(i, clutch)) beside_[static_cast<std::size_t>(i)] = clutch;
    }
  }
}

// Of a lock of which the coordinate is latched, if it has the latch.
void JointRows::add_latch(int lock, const Start& at, ContactRows& rows, std::vector<Cone>& cones) {
  const SwitchingForces::Lock& of = switching_.lock(lock);
  if (of.latch < 0) return;
  cones.push_back(Cone::within(rows.count(), -unlimited, unlimited));
  rows.add_lock(lock, of.sign);
  rows_.push_back({.lock = lock, .is_latch = true});
  if (of.limit < 0 || of.one_way) return;
  const double moved = at.h / 2 * switching_.speed(lock, at.v);
  for (const int side : {1, -1}) {
    const double depth = switching_.depth(lock, side).depth;
    if (depth > touch_tolerance && depth <= side * moved + touch_tolerance) rows_.back().passed = side * depth;
  }
}

void JointRows::add(const Start& at, ContactRows& rows, std::vector<Cone>& cones) {
  for (int i = 0; i < switching_.locks(); ++i) {
    if (switching_.engagement(i) > 0) {  // which leaves friction and limits nothing to hold
      add_latch(i, at, rows, cones);
    } else {
      add_friction(i, at, rows, cones);
      add_limits(i, at, rows, cones);
    }
  }
}

void JointRows::add_friction(int lock, const Start& at, ContactRows& rows, std::vector<Cone>& cones) {
  if (switching_.lock(lock).friction < 0) return;
  const double speed = switching_.speed(lock, at.v);
  const double change = at.h * std::abs(switching_.speed(lock, at.vdot));
  // What friction has held is at rest, but for the speed that a projection may have given it. Where an input jumps, it
  // is no longer.
  const LockForces& last = at.last[static_cast<std::size_t>(lock)];
  const bool was_held = last.motion == 0 && last.friction != 0 && std::abs(speed) <= negligible_part * change;
  const bool slides = !was_held && std::abs(speed) > rest_speed;
  Row row{.lock = lock, .slides = slides ? (speed > 0 ? 1 : -1) : 0};
  row.at_rest = switching_.sticking_limit(lock);
  row.sliding = slides ? switching_.sliding_limit(lock, speed) : row.at_rest;
  look_for_numbers(row);
  cones.push_back(Cone::within(rows.count(), 0, 0));
  set_friction_of(row, at.h, cones.back());
  rows.add_lock(lock, switching_.lock(lock).sign);
  rows_.push_back(row);
}

void JointRows::add_limits(int lock, const Start& at, ContactRows& rows, std::vector<Cone>& cones) {
  const SwitchingForces::Lock& of = switching_.lock(lock);
  if (of.limit < 0) return;
  const double speed = switching_.speed(lock, at.v);
  const double change = at.h * std::abs(switching_.speed(lock, at.vdot));
  for (const int side : {1, -1}) {
    const double depth = switching_.depth(lock, side).depth;
    // A bound that other impulses may drive the coordinate to is struck in the next step.
    if (!(depth + at.h * (std::abs(speed) + change) >= -touch_tolerance)) continue;
    cones.push_back(side > 0 ? Cone::within(rows.count(), -unlimited, 0) : Cone::within(rows.count(), 0, unlimited));
    rows.add_lock(lock, of.sign);
    rows_.push_back({.lock = lock, .side = side, .depth = depth, .is_of_speed = of.one_way});
  }
}

void JointRows::add_passed_limits(double h, const double* v1, ContactRows& rows, std::vector<Cone>& cones) {
  for (int i = 0; i < switching_.locks(); ++i) {
    const SwitchingForces::Lock& lock = switching_.lock(i);
    if (lock.limit < 0 || lock.one_way || switching_.engagement(i) > 0) continue;
    const double speed = switching_.speed(i, v1);
    const int side = speed > 0 ? 1 : -1;
    const double depth = switching_.depth(i, side).depth;
    const auto is_row = [&](const Row& row) { return row.lock == i && row.side == side; };
    if (!(depth + h / 2 * std::abs(speed) > touch_tolerance) || std::ranges::any_of(rows_, is_row)) continue;
    cones.push_back(Cone::within(rows.count(), 0, 0));
    rows.add_lock(i, lock.sign);
    rows_.push_back({.lock = i, .side = side, .depth = depth});
  }
}

void JointRows::look_for_numbers(const Row& row) {
  are_undefined_ = are_undefined_ || std::isnan(row.sliding.positive + row.sliding.negative);
}

// What slides comes to rest before it turns back, and is then held by up to the static friction.
bool JointRows::stops_before(const Row& row, int motion) { return row.slides == -motion && !row.turns_back; }

void JointRows::set_friction_of(const Row& row, double h, Cone& cone) {
  cone.lower = -h * (stops_before(row, 1) ? row.at_rest : row.sliding).against(1);
  cone.upper = h * (stops_before(row, -1) ? row.at_rest : row.sliding).against(-1);
}

bool JointRows::set_sliding_friction(double h, const double* v1, const double* vm, const double* x,
                                     std::span<Cone> cones) {
  bool changed = false;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    if (row.side != 0 || row.slides == 0) continue;
    Cone& cone = cones[i];
    const double held = row.slides * x[cone.first];
    row.turns_back = row.turns_back || (row.slides * switching_.speed(row.lock, v1) < -rest_speed &&
                                        held >= at_bound * h * row.at_rest.against(-row.slides));
    const Cone before = cone;
    if (switching_.loads().empty()) row.sliding = switching_.sliding_limit(row.lock, switching_.speed(row.lock, vm));
    set_friction_of(row, h, cone);
    changed = changed || std::abs(cone.upper - before.upper) > negligible_change * before.upper ||
              std::abs(cone.lower - before.lower) > negligible_change * -before.lower;
  }
  return changed || have_loads();  // which follow from the velocities, too
}

bool JointRows::have_loads() const {
  return !switching_.loads().empty() && std::ranges::any_of(rows_, &Row::is_friction);
}

void JointRows::read_limits(std::vector<double>& out, std::vector<LoadIteration::Limit>& kinds) const {
  using Limit = LoadIteration::Limit;
  out.clear();
  kinds.clear();
  for (const Row& row : rows_) {
    if (!row.is_friction()) continue;
    append({row.at_rest, row.sliding}, out);
    const bool has_load = switching_.loads().acts_on(switching_.lock(row.lock).friction);
    const Limit at_rest = has_load ? Limit::of_rest : Limit::without_load;
    const Limit sliding = has_load && row.slides != 0 ? Limit::of_motion : at_rest;
    kinds.insert(kinds.end(), {at_rest, at_rest, sliding, sliding});
  }
}

void JointRows::add_reached_limits(const double* x, std::span<const Cone> cones, std::vector<int>& out) const {
  int first = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    if (!row.is_friction()) continue;
    const double impulse = x[cones[i].first];
    const int motion = impulse < 0 ? 1 : -1;  // that friction opposes
    const double limit = motion > 0 ? -cones[i].lower : cones[i].upper;
    const int of_sliding = stops_before(row, motion) ? 0 : 2;  // in the order of append()
    if (std::abs(impulse) >= at_bound * limit) out.push_back(first + of_sliding + (motion > 0 ? 0 : 1));
    first += 4;
  }
}

void JointRows::find_limits(const double* vm, std::vector<double>& out) const {
  out.clear();
  for (const Row& row : rows_) {
    if (!row.is_friction()) continue;
    const DirectedLimit at_rest = switching_.sticking_limit(row.lock);
    const DirectedLimit sliding =
        row.slides == 0 ? at_rest : switching_.sliding_limit(row.lock, switching_.speed(row.lock, vm));
    append({at_rest, sliding}, out);
  }
}

void JointRows::set_limits(double h, const double* limits, std::span<Cone> cones) {
  const auto next = [&] {
    const DirectedLimit out{.positive = std::max(0.0, limits[0]), .negative = std::max(0.0, limits[1])};
    limits += 2;
    return out;
  };
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& row = rows_[i];
    if (!row.is_friction()) continue;
    row.at_rest = next();
    row.sliding = next();
    set_friction_of(row, h, cones[i]);
  }
}

bool JointRows::may_hold(const Row& joint, Hold hold, double h, std::span<const Cone> cones,
                         const double* speeds) const {
  if (!joint.is_friction()) return hold != Hold::none;
  if (hold != Hold::all) return false;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    if (row.lock != joint.lock || row.side == 0 || row.is_of_speed) continue;
    if (row.depth + row.side * h / 2 * speeds[cones[i].first] > touch_tolerance) return false;
  }
  return true;
}

bool JointRows::any_stops(const double* v1) const {
  return std::ranges::any_of(rows_, [&](const Row& row) {
    return row.side == 0 && row.slides != 0 && std::abs(switching_.speed(row.lock, v1)) <= rest_speed;
  });
}

bool JointRows::find_engaged(const double* v, double residual, char* found) const {
  const double slow = std::max(rest_speed, left_tolerances * residual);
  bool any = false;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    if (!rows_[i].is_latch) continue;
    const int joint = switching_.lock(rows_[i].lock).latched_joint;
    const bool moves = std::ranges::any_of(rows_, [&](const Row& other) {
      return other.is_latch && switching_.lock(other.lock).latched_joint == joint &&
             std::abs(switching_.speed(other.lock, v)) > slow;
    });
    if (moves) found[i] = 1;
    any = any || moves;
  }
  return any;
}

// What has stopped at a bound is in contact with it. At rest, a limit pushes, and what pulls is friction.
void JointRows::remember(double h, const double* v1, const double* x, std::span<const Cone> cones,
                         std::vector<LockForces>& out) {
  std::ranges::fill(out, LockForces{});
  moving_latch_ = {};
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    const double force = x[cones[i].first] / h;
    const double speed = switching_.speed(row.lock, v1);
    const bool rests = std::abs(speed) <= rest_speed;
    LockForces& at = out[static_cast<std::size_t>(row.lock)];
    if (row.is_latch) {
      at.latch = force;
      at.is_latched = true;
      if (!(std::abs(speed) < std::abs(moving_latch_.speed))) moving_latch_ = {row.lock, speed};
    } else if (row.side == 0) {
      at.friction = force;
      at.motion = rests ? 0 : speed > 0 ? 1 : -1;
    } else {
      at.limit += force;
      if (rests && (force != 0 || row.depth >= -touch_tolerance)) at.contact = row.side;
    }
  }
  share(out);
}

// The laws of a coordinate at rest may hold it against each other: what a bound can exert of their sum it exerts, and
// what none can is friction.
void JointRows::share(std::vector<LockForces>& out) const {
  for (std::size_t i = 0; i < out.size(); ++i) {
    LockForces& at = out[i];
    LockForces* const clutch = beside_[i] < 0 ? nullptr : &out[static_cast<std::size_t>(beside_[i])];
    const bool is_held = at.contact != 0 || (clutch != nullptr && clutch->contact != 0);
    if (!is_held || (clutch == nullptr && switching_.lock(static_cast<int>(i)).friction < 0)) continue;
    const double sum = at.friction + at.limit + (clutch == nullptr ? 0 : clutch->limit);
    at.limit = at.contact * sum < 0 ? sum : 0;
    const bool by_clutch = clutch != nullptr && at.limit == 0 && clutch->contact * sum < 0;
    if (clutch != nullptr) clutch->limit = by_clutch ? sum : 0;
    at.friction = by_clutch ? 0 : sum - at.limit;
  }
}

}  // namespace gelenk
