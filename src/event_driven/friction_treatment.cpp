// SPDX-License-Identifier: BSD-3-Clause
// What dry friction does where derivatives are taken: the part of LockModes for linear models and sensitivities.
#include <algorithm>

#include "event_driven/lock_modes.h"
#include "kinematics/force_modes.h"

namespace gelenk {
namespace {

// Friction at rest that uses this fraction of its limit is about to slip.
constexpr double boundary_fraction = 1e-9;

}  // namespace

int LockModes::treat(FrictionTreatment friction, double t, const double* y) {
  State out = modes_;
  for (int i = 0; i < count(); ++i) {
    if (!has_friction(i) || modes_.contacts[i] != 0 || is_latched(i)) continue;
    int& motion = out.motions[i];
    if (friction == FrictionTreatment::locked) motion = 0;
    const bool is_free = friction == FrictionTreatment::off ||
                         (friction == FrictionTreatment::sliding && motion == 0) ||
                         (friction == FrictionTreatment::present && forces_.sticking_limit(i).vanishes);
    if (is_free) motion = mode_released;
  }
  set_state(out);
  return friction == FrictionTreatment::present ? on_boundary(t, y) : -1;
}

int LockModes::on_boundary(double t, const double* y) {
  const bool has_loads = !forces_.loads().empty();
  if (any_at_rest_ || has_loads) find_holding_forces(t, y);
  if (const int unloaded = has_loads ? forces_.loads().unloaded() : -1; unloaded >= 0) return unloaded;
  dynamics_.set_position(y);
  const double* v = y + nq_;
  for (int i = 0; i < count(); ++i) {
    const SwitchingForces::Lock& lock = forces_.lock(i);
    if (is_latched(i)) continue;
    if (lock.latch >= 0 && forces_.engagement(i) > 0) return lock.latch;  // the impact is still to come
    if (const int law = rests(i) ? boundary_at_rest(i) : boundary_in_motion(i, v); law >= 0) return law;
  }
  return -1;
}

// Of a lock that is not at rest: the law of which its state is at the boundary; -1: none.
int LockModes::boundary_in_motion(int lock, const double* v) const {
  const SwitchingForces::Lock& of = forces_.lock(lock);
  if (has_friction(lock) && modes_.motions[lock] != mode_released && is_slow(lock, v)) return of.friction;
  if (of.limit >= 0 && touched_side(lock) != 0 && (!of.one_way || is_slow(lock, v))) return of.limit;
  return -1;
}

int LockModes::boundary_at_rest(int lock) const {
  const auto safe = [&](int direction) {
    const double limit = forces_.sticking_limit(lock).against(direction);
    return limit - std::max(boundary_fraction * limit, forces_.slack(lock));
  };
  const bool may_rise = holding_[lock] >= safe(-1) && modes_.contacts[lock] >= 0;
  const bool may_fall = holding_[lock] <= -safe(1) && modes_.contacts[lock] <= 0;
  if (!may_rise && !may_fall) return -1;
  return modes_.contacts[lock] != 0 ? forces_.lock(lock).limit : forces_.lock(lock).friction;
}

}  // namespace gelenk
