// SPDX-License-Identifier: BSD-3-Clause
// What outputs show of friction and limits of joints: their forces and modes.
#pragma once

#include <span>
#include <vector>

#include "event_driven/lock_modes.h"

namespace gelenk {

class JointOutputs {
 public:
  // All must outlive it. sides: the held modes of all forces with modes.
  JointOutputs(Dynamics& dynamics, LockModes& locks, const std::vector<int>& sides);

  // Records them after the accelerations have been solved for in a ModePreview.
  void record();
  // The same of forces that steps have determined, by lock.
  void record(std::span<const LockForces> locks);
  // Those of the last accelerations in the held modes, which are not recorded: by force with modes.
  const std::vector<double>& present();
  const std::vector<int>& held_sides() const { return sides_; }
  // Makes constraint forces follow the recorded forces, after another solve() at the same state.
  void apply() { forces_.holding_forces().redistribute(recorded_holding_); }
  // By force with modes.
  const std::vector<double>& forces() const { return recorded_forces_; }
  const std::vector<int>& sides() const { return recorded_sides_; }

 private:
  void read(const std::vector<double>& holding, std::vector<double>& out);

  Dynamics& dynamics_;
  SwitchingForces& forces_;
  LockModes& locks_;
  const std::vector<int>& sides_;
  std::vector<int> recorded_sides_;
  std::vector<double> recorded_forces_, holding_;  // by force
  std::vector<double> recorded_holding_;           // by lock
  std::vector<double> present_forces_;             // by force
};

}  // namespace gelenk
