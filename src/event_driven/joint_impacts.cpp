// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/joint_impacts.h"

#include <algorithm>
#include <cmath>

#include "kinematics/force_modes.h"
#include "nonsmooth/rounding.h"

namespace gelenk {
namespace {

// A speed towards a bound that an impact leaves, relative to the largest: no force can stop it.
constexpr double stopped_fraction = 1e-8;

}  // namespace

std::vector<JointImpacts::Struck> JointImpacts::struck(const double* y, const std::vector<int>& returning,
                                                       const LockModes::State& before) const {
  const double* v = y + modes_.nq_;
  std::vector<Struck> out;
  for (int i = 0; i < modes_.count(); ++i) {
    const SwitchingForces::Lock& lock = forces_.lock(i);
    if (modes_.modes_.latched[i] != 0) {
      out.push_back({.lock = i, .stops = true, .approaches = !modes_.is_slow(i, v)});
      continue;
    }
    const int side = lock.limit < 0 ? 0 : modes_.touched_side(i);
    const bool returns = std::ranges::find(returning, i) != returning.end();
    if (side == 0 && !returns) continue;
    const bool approaches = side * forces_.speed(i, v) > 0 && !modes_.is_slow(i, v);
    out.push_back({.lock = i,
                   .side = side,
                   .restitution = returns ? 0 : forces_.depth(i, side).restitution,
                   .poisson = lock.poisson,
                   .stops = returns,
                   .approaches = approaches || (returns && side != 0 && before.contacts[i] == 0)});
  }
  return out;
}

std::vector<JointImpacts::Bound> JointImpacts::near_bounds(double distance) const {
  std::vector<Bound> out;
  for (int i = 0; i < modes_.count(); ++i) {
    const SwitchingForces::Lock& lock = forces_.lock(i);
    if (lock.limit < 0 || lock.one_way || modes_.modes_.contacts[i] != 0) continue;
    const int touched = modes_.touched_side(i);
    for (const int side : {1, -1}) {
      const double depth = forces_.depth(i, side).depth;
      if (-depth < distance) out.push_back({i, side, modes_.limit_indicator(i, side), -depth, side == touched});
    }
  }
  return out;
}

void JointImpacts::let_go() {
  if (modes_.empty()) return;
  LockModes::State open = modes_.state();
  for (int i = 0; i < modes_.count(); ++i) {
    if (!modes_.rests(i)) continue;
    open.motions[i] = mode_released;
    open.contacts[i] = 0;
    open.latched[i] = 0;
  }
  modes_.set_state(open);
}

bool JointImpacts::is_lost(const Struck& at, double speed, const double* vdot, const std::vector<double>& holding,
                           double mobility) const {
  const double back = modes_.modes_.contacts[at.lock] != 0
                          ? -at.side * holding[static_cast<std::size_t>(at.lock)] * mobility
                          : at.side * forces_.speed(at.lock, vdot);
  return modes_.returns_to(at.lock, at.side, 0, speed, back);
}

void JointImpacts::finish(double t, const double* y, const std::vector<Struck>& struck,
                          const std::vector<double>& rebounds, bool found, int other) {
  const double* v = y + modes_.nq_;
  const double fastest = fastest_of({v, static_cast<std::size_t>(modes_.nv_)});
  bool any_latched = false;
  for (std::size_t i = 0; i < struck.size(); ++i) {
    const Struck& at = struck[i];
    modes_.modes_.leaves_from[at.lock] = modes_.modes_.contacts[at.lock] == 0 ? modes_.leaving_depth_of(at.lock) : 0;
    if (modes_.modes_.latched[at.lock] != 0) {
      const SwitchingForces::Lock& lock = forces_.lock(at.lock);
      any_latched = any_latched || at.approaches;
      if (std::abs(rebounds[i]) > stopped_fraction * fastest) modes_.modes_.unstoppable = 2 * lock.latch;
      continue;
    }
    if (at.side == 0) continue;
    const int indicator = modes_.limit_indicator(at.lock, at.side);
    if (at.approaches) {
      ++modes_.counts_.impacts;
      if (!forces_.lock(at.lock).one_way) modes_.log_.add({t, indicator, true, !found, other});
    }
    if (rebounds[i] < -stopped_fraction * fastest) modes_.modes_.unstoppable = indicator;
  }
  if (any_latched) ++modes_.counts_.impacts;
  for (int i = 0; i < modes_.count(); ++i) {
    if (!modes_.is_slow(i, v)) modes_.triggered_[static_cast<std::size_t>(i)] = LockModes::nothing;
  }
}

}  // namespace gelenk
