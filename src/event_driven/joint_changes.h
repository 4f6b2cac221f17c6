// SPDX-License-Identifier: BSD-3-Clause
// When the modes of friction and limits of joints change, and what follows besides impacts and decisions. All functions
// are possible where there are none.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "event_driven/lock_modes.h"

namespace gelenk {

class JointChanges {
 public:
  // modes must outlive it.
  explicit JointChanges(LockModes& modes) : modes_(modes), forces_(modes.forces_) {}

  bool empty() const { return modes_.empty(); }
  const LockModes::State& state() const { return modes_.state(); }
  void set_state(const LockModes::State& state) {
    if (!empty()) modes_.set_state(state);
  }

  // --- where a step begins at (t, y) ---
  // Finds events at its very start, which cannot be located within it: a speed that is zero and about to change its
  // sign, and a bound that is reached. Returns whether there are events.
  bool find_events_at_start(double t, const double* y);
  // Whether the modes do not follow from what is remembered alone. jumped: inputs may have jumped since they did.
  bool are_doubtful(double t, const double* y, bool jumped) { return !empty() && modes_.is_doubtful(t, y, jumped); }
  bool any_wrong_speed(const double* y) const { return modes_.any_wrong_speed(y + modes_.nq_); }
  bool is_triggered() const;
  // Whether something at rest is, of which the force has reached its bound.
  bool breaks_away() const;

  // --- redundant forces ---
  // Of the indicators of friction and limits g, those that say that something at rest gives way. Returns the number of
  // coordinates at rest.
  std::size_t find_yielding(double* g, std::vector<double*>& out) const;
  // Whether the last solve() needed forces that friction and limits cannot exert.
  bool exceed_limits() const { return modes_.any_at_rest_ && modes_.exceed(forces_.holding_forces().values()); }

  // --- changes ---
  // Forgets all modes, at the start of a run; where a prescribed motion jumps, not those of latches.
  void begin_run(bool keeps_latches);
  // What was at rest before, and has not been moved but by rounding, is stopped by the decision that follows; so is
  // what friction could have kept at rest in a step of the length estimated_over, of motions known by values alone.
  void stop_unmoved(const double* y, const LockModes::State& before, double estimated_over);
  void forget_events() { std::ranges::fill(modes_.triggered_, LockModes::nothing); }
  // Forgets bounds that were met in a rebound, which may still be beyond them by rounding; at the position of
  // `dynamics`.
  void forget_rebounds(const double* y);
  // At the beginning of a change.
  void begin_change() { modes_.modes_.unstoppable = -1; }
  // Lets go what is no longer held where rounding hides it, and what is at its limit, too: one alone could not move.
  void force_away();
  // The first coordinate that finish() stops, by lock; -1: it stops none. What it says in a message.
  int first_to_stop(const double* y) const;
  std::string text_of_stop(int lock) const;
  // Stops what rests, and what begins to move from there.
  void finish(double* y);
  void stop(double* y) { modes_.stop(y + modes_.nq_); }
  // Of joints that something has set in motion at this instant, those that come to rest before the motion matters.
  // stopped: what friction has stopped in the same way at this instant, which stays at rest; brought up to date.
  std::vector<int> find_returning(double t, const double* y, const LockModes::State& before, std::vector<int>& stopped);
  // Whether joints that were to slip in one direction move in the other one, since closing contacts has set them in
  // motion. Their friction is no longer to be decided on as at rest.
  bool have_turned(const double* y);
  // Makes an event of the friction with this index among all forces with modes, which stops at once; returns its lock.
  int stop_friction(int force);
  void record_changes(double t, const LockModes::State& before);

 private:
  void find_reached_bounds(int lock, const double* v);
  bool uses_limit_up(int lock) const;
  bool could_be_held(int lock, const double* v, double span);
  bool returns(int lock, const LockModes::State& before, const double* v) const;

  LockModes& modes_;
  SwitchingForces& forces_;
};

}  // namespace gelenk
