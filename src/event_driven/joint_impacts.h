// SPDX-License-Identifier: BSD-3-Clause
// What friction and limits of joints contribute to an impact, at the position of `dynamics`.
#pragma once

#include <vector>

#include "event_driven/lock_modes.h"

namespace gelenk {

class JointImpacts {
 public:
  // modes must outlive it.
  explicit JointImpacts(LockModes& modes) : modes_(modes), forces_(modes.forces_) {}

  struct Struck {
    int lock = 0;
    int side = 0;            // 1: its upper bound, -1: its lower one; 0: none, of what stops
    double restitution = 0;  // of this impact
    bool poisson = false;    // Poisson's law instead of Newton's
    bool stops = false;      // it does not leave, since it would return at once
    bool approaches = false;
  };
  // The limits that are touched, and what stops as well (JointChanges::find_returning); y: before the impact; before:
  // the modes before all that happens at this instant.
  std::vector<Struck> struck(const double* y, const std::vector<int>& returning, const LockModes::State& before) const;
  // Releases what is at rest, for the equations of an impact.
  void let_go();
  // The forces of the last solve() that keep coordinates at rest, by lock.
  const std::vector<double>& holding_forces() const { return forces_.holding_forces().values(); }
  // Whether a rebound at this speed is lost in the rounding of the position. vdot, holding: the accelerations before
  // the impact, and holding_forces() in them; mobility: acceleration per force.
  bool is_lost(const Struck& at, double speed, const double* vdot, const std::vector<double>& holding,
               double mobility) const;
  // Counts series of impacts that have ended, of what approached its bound.
  void count_closed_series(const Struck& at) { modes_.counts_.closed_series += at.approaches && !at.stops ? 1 : 0; }
  // Bounds nearer than this that are not closed [rad, m]; indicator: of the event that meets it; is_touched: within
  // rounding, so that impulses act on it.
  struct Bound {
    int lock = 0, side = 0, indicator = 0;
    double distance = 0;
    bool is_touched = false;
  };
  std::vector<Bound> near_bounds(double distance) const;
  // The rate of the distance to a bound, from velocities; or its acceleration, from vdot.
  double distance_rate(const Bound& at, const double* v) const { return -at.side * forces_.speed(at.lock, v); }
  double tolerance() const { return modes_.tolerance(); }
  // After it, in the modes before it: records what has been struck. y: after it; rebounds: by element of `struck`,
  // speeds after it away from what is struck; other: see Event.
  void finish(double t, const double* y, const std::vector<Struck>& struck, const std::vector<double>& rebounds,
              bool found, int other);

 private:
  LockModes& modes_;
  SwitchingForces& forces_;
};

}  // namespace gelenk
