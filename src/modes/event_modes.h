// SPDX-License-Identifier: BSD-3-Clause
// The modes of forces with several (stops, friction, limits), held from one event to the next. The mode of a stop
// follows from the state; those of friction and limits are remembered, and change at events.
#pragma once

#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "event/event_log.h"
#include "event/event_source.h"
#include "modes/lock_modes.h"

namespace gelenk {

// Modes that are decided together with those of friction and limits.
class ConnectedModes : public EventSource {
 public:
  // After indicator_values(): where what is at rest or closed seems to give way, although redundant forces can be
  // distributed so that it does not, corrects the indicators of friction and limits, and its own.
  virtual void redistribute(double t, const double* y, double* locks, double* own) = 0;
  // Whether the forces of the last accelerations are the only ones that have their effect.
  virtual bool are_forces_unique() const = 0;
};

class EventModes final : public EventSource {
 public:
  // nq, nv: number of coordinates and velocities in y. log: receives the events.
  EventModes(ModeEquations& equations, Dynamics& dynamics, int nq, int nv, EventLog& log);

  // Two indicators for each force with modes. A stop or limit: for its upper and its lower bound, positive while it is
  // in contact. Friction: of motion in the positive and in the negative direction, positive during it.
  // There follow those of others, or of the loads of friction; contacts and such loads exclude each other.
  int indicators() const override {
    return own_indicators() + (others_ == nullptr ? forces_.loads().signed_count() : others_->indicators());
  }
  int own_indicators() const { return 2 * static_cast<int>(sides_.size()); }
  // Adds the modes of contacts, whose indicators follow, and which change those of friction and limits, too; they must
  // outlive this.
  void add(ConnectedModes& others) { others_ = &others; }
  void indicator_values(double t, const double* y, double* g, double* gdot) override;
  bool recall_mode(double t, double* y) override;
  void remembered_mode(bool* positive) const override;
  void hold_mode(double t, const bool* positive) override;
  double mode_exit_time() const override;
  void found_event(double t, int indicator, bool positive) override;
  void change_mode(double t, double* y) override;
  std::string refusal() const override;
  // Why the last accelerations are not determined; otherwise empty.
  std::string indeterminacy() const;

  // Records whether an evaluation at t with velocities v, at the position of `dynamics`, is outside the held mode.
  void watch(double t, const double* v) {
    if (held_ && t > held_from_ && t < mode_exit_time_) check(t, v);
  }
  // The same after the accelerations have been solved for: whether what is kept at rest can no longer be.
  void watch_holding_forces(double t) {
    if (held_ && t > held_from_ && t < mode_exit_time_ && locks_.are_overloaded() &&
        (others_ == nullptr || others_->are_forces_unique()))
      mode_exit_time_ = t;
  }

  LockModes& locks() { return locks_; }
  const LockModes& locks() const { return locks_; }
  // The modes of all forces with modes in which derivatives are taken at (t, y), the present state: those in which a
  // step would begin; empty: those of the state. boundary: see LockModes::treat().
  struct Present {
    std::vector<int> sides;
    int boundary = -1;
  };
  Present present(double t, const double* y, FrictionTreatment friction);
  // Records what outputs show, the forces and modes of friction and limits, after the accelerations have been solved
  // for in a ModePreview.
  void record_outputs();
  // The same of forces that others have determined, by lock.
  void record_outputs(std::span<const LockForces> locks);
  // Makes constraint forces follow the recorded forces, after another solve() at the same state.
  void apply_recorded_forces() { forces_.holding_forces().redistribute(recorded_holding_); }
  const std::vector<double>& recorded_forces() const { return recorded_forces_; }
  const std::vector<int>& recorded_sides() const { return recorded_sides_; }

 private:
  int smooth_indicators() const override { return others_ == nullptr ? indicators() : own_indicators(); }
  double touch_within(double t0, const double* y0, double t1, const double* y1) override {
    return others_ == nullptr ? INFINITY : others_->touch_within(t0, y0, t1, y1);
  }
  void keep_directions_below(double speed) override {
    if (others_ != nullptr) others_->keep_directions_below(speed);
  }
  void check(double t, const double* v);
  bool is_outside();

  Dynamics& dynamics_;
  Branching& forces_;
  int nq_;
  EventLog& log_;
  std::vector<int> sides_, present_sides_;  // of the forces: held, and those of the present state
  std::vector<double> g_, gdot_;            // indicators
  std::vector<int> recorded_sides_;
  std::vector<double> recorded_forces_, holding_;  // by force
  std::vector<double> recorded_holding_;           // by lock
  bool held_ = false;                              // a mode is held
  double held_from_ = 0;                           // s: start of the held mode
  double mode_exit_time_ = INFINITY;               // s: see EventSource
  LockModes locks_;
  ConnectedModes* others_ = nullptr;
};

}  // namespace gelenk
