// SPDX-License-Identifier: BSD-3-Clause
#include "nonsmooth/law_audit.h"

#include <algorithm>
#include <cmath>

#include "nonsmooth/rounding.h"

namespace gelenk {
namespace {

// Beyond a limit, this number of slacks (ForceRounding::slack) is rounding, but nothing beyond all forces of the scene
// (ForceRounding::largest_force): where constraint equations hardly permit a motion, the slack has no bound.
constexpr double slacks = 1e4;
// Speeds up to this, relative to the largest or 1, may have either sign by rounding.
constexpr double sign_rounding = 1e-8;
// The same in time steps: far more than solvers leave of speeds.
constexpr double stepped_rounding = 1e-4;
// A limit acts within this multiple of what counts as contact with it (some 1e-12); and may be passed by this one,
// which is as small as errors of positions at common tolerances, by which loops and prescribed motions move it.
constexpr double distances = 1e4;
constexpr double passed_distances = 1e6;

using Kind = BrokenLaw::Kind;

double slack_of(const SwitchingForces& switching_forces, int i) {
  return std::min(slacks * switching_forces.slack(i), switching_forces.largest_force(i)) + least_audited_force;
}

void audit_friction(const SwitchingForces& switching_forces, int i, double friction, double speed, bool moves,
                    LawAudit& audit) {
  const int law = switching_forces.lock(i).friction;
  const int direction = friction > 0 ? -1 : 1;
  double permitted = switching_forces.sticking_limit(i).against(direction);
  // Some laws grow with the speed.
  if (moves) permitted = std::max(permitted, switching_forces.sliding_limit(i, speed).against(direction));
  const bool pushes = moves && friction * speed > 0;
  if (std::abs(friction) <= permitted && !pushes) return;  // most often, and the slack costs more than this
  const double slack = slack_of(switching_forces, i);
  audit.add((std::abs(friction) - permitted) / (audited_fraction * permitted + slack),
            {Kind::friction_exceeded, law, friction, permitted});
  if (pushes) audit.add(std::abs(friction) / slack, {Kind::friction_along_motion, law, friction, speed});
}

void audit_limit(const SwitchingForces& switching_forces, int i, double force, LawAudit& audit) {
  const SwitchingForces::Lock& lock = switching_forces.lock(i);
  const int side = force < 0 ? 1 : -1;  // the bound that would push like this
  const SwitchingForces::Depth at = switching_forces.depth(i, side);
  const double excess = force == 0 ? 0 : std::abs(force) / slack_of(switching_forces, i);
  if (lock.one_way) {
    if (std::isinf(at.depth)) audit.add(excess, {Kind::limit_pulls, lock.limit, force});
    return;
  }
  if (at.depth < -distances * at.tolerance) {
    const bool pulls = switching_forces.depth(i, -side).depth >= -distances * at.tolerance;
    audit.add(excess, pulls ? BrokenLaw{Kind::limit_pulls, lock.limit, force}
                            : BrokenLaw{Kind::limit_not_reached, lock.limit, force, -at.depth});
  }
  for (const int of : {1, -1}) {
    const SwitchingForces::Depth passed = switching_forces.depth(i, of);
    audit.add(passed.depth / (passed_distances * passed.tolerance), {Kind::limit_passed, lock.limit, 0, passed.depth});
  }
}

}  // namespace

LawAudit audit_latch(const SwitchingForces& switching_forces, int lock, double speed, std::span<const double> v) {
  LawAudit audit;
  audit.add(std::abs(speed) / (stepped_rounding * fastest_of(v)),
            {Kind::latch_moves, switching_forces.lock(lock).latch, speed});
  return audit;
}

LawAudit audit_locks(const SwitchingForces& switching_forces, std::span<const double> forces, const double* v, int nv) {
  const double fastest = fastest_of({v, static_cast<std::size_t>(nv)});
  LawAudit audit;
  for (int i = 0; i < switching_forces.locks(); ++i) {
    const SwitchingForces::Lock& lock = switching_forces.lock(i);
    const double speed = switching_forces.speed(i, v);
    const bool moves = std::abs(speed) > sign_rounding * fastest;
    if (lock.latch >= 0 && switching_forces.hold_coordinate(i))
      audit.add(std::abs(speed) / (sign_rounding * fastest), {Kind::latch_moves, lock.latch, speed});
    double friction = 0;
    for (const int law : switching_forces.lock(i).frictions) friction += forces[static_cast<std::size_t>(law)];
    if (lock.friction >= 0) audit_friction(switching_forces, i, friction, speed, moves, audit);
    if (lock.limit >= 0) audit_limit(switching_forces, i, forces[static_cast<std::size_t>(lock.limit)], audit);
  }
  return audit;
}

}  // namespace gelenk
