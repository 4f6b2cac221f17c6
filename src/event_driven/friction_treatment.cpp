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
    if (!rests(i)) {
      if (has_friction(i) && modes_.motions[i] != mode_released && is_slow(i, v)) return lock.friction;
      if (lock.limit >= 0 && touched_side(i) != 0 && (!lock.one_way || is_slow(i, v))) return lock.limit;
      continue;
    }
    const auto safe = [&](int direction) {
      const double limit = forces_.sticking_limit(i).against(direction);
      return limit - std::max(boundary_fraction * limit, forces_.slack(i));
    };
    const bool may_rise = holding_[i] >= safe(-1) && modes_.contacts[i] >= 0;
    const bool may_fall = holding_[i] <= -safe(1) && modes_.contacts[i] <= 0;
    if (may_rise || may_fall) return modes_.contacts[i] != 0 ? lock.limit : lock.friction;
  }
  return -1;
}

}  // namespace gelenk
