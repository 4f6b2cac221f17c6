// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/joint_latches.h"

#include <cmath>

#include "kinematics/force_modes.h"

namespace gelenk {
namespace {

// An input this close to the threshold of a latch may be on either side of it by rounding.
constexpr double threshold_rounding = 1e-9;
// Displacements of what is latched that are rounding of closing the loops [rad, natural units of length].
constexpr double latched_displacement = 1e-9;

}  // namespace

// An input that crosses the threshold does so at an event, after which rounding decides on which side it is.
void JointLatches::find_events(double t, const double* y, bool jumped) {
  if (!modes_.any_latch_) return;
  modes_.equations_.bring_inputs(t, y);
  for (int i = 0; i < modes_.count(); ++i) {
    if (is_switched(i, jumped)) modes_.triggered_[static_cast<std::size_t>(i)] = LockModes::by_latch;
  }
}

// Whether the inputs say otherwise than the mode of a latch.
bool JointLatches::is_switched(int lock, bool jumped) const {
  if (forces_.lock(lock).latch < 0) return false;
  const double engagement = forces_.engagement(lock);
  const bool is_known = jumped || std::abs(engagement) > threshold_rounding;
  return is_known && (engagement > 0 ? 1 : 0) != modes_.modes_.latched[lock];
}

// Where it is engaged, friction is at rest without a force, and limits are left.
void JointLatches::switch_part(int lock, int latched, LockModes::State& next) const {
  const auto at = static_cast<std::size_t>(lock);
  next.latched[at] = latched;
  if (latched == 0) return;
  next.motions[at] = modes_.has_friction(lock) ? 0 : mode_released;
  next.contacts[at] = 0;
  next.leaves_from[at] = 0;
}

// All parts of a latch together: the indicators of each cross their zeros by themselves.
void JointLatches::switch_found() {
  if (!modes_.any_latch_) return;
  LockModes::State next = modes_.state();
  for (int i = 0; i < modes_.count(); ++i) {
    if (modes_.triggered_[static_cast<std::size_t>(i)] != LockModes::by_latch) continue;
    const int latched = 1 - modes_.modes_.latched[i];
    each_part(i, [&](int part) { switch_part(part, latched, next); });
  }
  for (LockModes::Trigger& trigger : modes_.triggered_) {
    if (trigger == LockModes::by_latch) trigger = LockModes::nothing;
  }
  if (next == modes_.state()) return;
  modes_.set_state(next);
  modes_.equations_.mode_changed();
}

void JointLatches::set(double t, const double* y, bool jumped) {
  if (!modes_.any_latch_) return;
  modes_.equations_.bring_inputs(t, y);
  LockModes::State next = modes_.state();
  for (int i = 0; i < modes_.count(); ++i) {
    if (!is_switched(i, jumped)) continue;
    const int latched = 1 - modes_.modes_.latched[i];
    bool moves = false;
    each_part(i, [&](int part) { moves = moves || !modes_.is_slow(part, y + modes_.nq_); });
    if (latched == 0 || !moves) switch_part(i, latched, next);
  }
  if (next != modes_.state()) modes_.set_state(next);
}

void JointLatches::refuse_moved(const std::vector<int>& latched, const double* before, const double* q) {
  for (int i = 0; i < modes_.count(); ++i) {
    if (latched[static_cast<std::size_t>(i)] == 0 || modes_.modes_.latched[i] == 0) continue;
    const SwitchingForces::Lock& lock = forces_.lock(i);
    // A joint that closes a loop is in a plane, where coordinates have the numbers of velocities.
    const double moved = lock.latched_q >= 0 ? q[lock.latched_q] - before[lock.latched_q]
                                             : forces_.speed(i, q) - forces_.speed(i, before);
    if (std::abs(moved) > latched_displacement) modes_.modes_.unstoppable = 2 * lock.latch;
  }
}

}  // namespace gelenk
