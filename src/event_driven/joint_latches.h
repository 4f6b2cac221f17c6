// SPDX-License-Identifier: BSD-3-Clause
// Locks of joints that inputs engage and release: when their modes change. Their impacts and forces are those of
// JointImpacts and LockModes.
#pragma once

#include "event_driven/lock_modes.h"

namespace gelenk {

class JointLatches {
 public:
  // modes must outlive it.
  explicit JointLatches(LockModes& modes) : modes_(modes), forces_(modes.forces_) {}

  // Finds those that the inputs at (t, y) switch. jumped: inputs may have jumped since the last event.
  void find_events(double t, const double* y, bool jumped);
  // Engages and releases those of which events have been found; those of joints in motion by an impact to come.
  void switch_found();
  // Engages and releases all as their inputs at (t, y) say, but those of joints in motion: they are not engaged before
  // the impact.
  void set(double t, const double* y, bool jumped);
  // The run cannot continue where a prescribed motion has jumped and moved a latch that holds now and held before
  // (latched, by lock), from the coordinates before to the others, since closed loops leave it no choice.
  void refuse_moved(const std::vector<int>& latched, const double* before, const double* q);

 private:
  bool is_switched(int lock, bool jumped) const;
  void switch_part(int lock, int latched, LockModes::State& next) const;
  // Calls visit(lock) for all parts of the latch of which this lock has one.
  template <class Visit>
  void each_part(int lock, Visit visit) const {
    for (int k = 0; k < modes_.count(); ++k) {
      if (forces_.lock(k).latch >= 0 && forces_.lock(k).latched_joint == forces_.lock(lock).latched_joint) visit(k);
    }
  }

  LockModes& modes_;
  SwitchingForces& forces_;
};

}  // namespace gelenk
