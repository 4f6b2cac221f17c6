// SPDX-License-Identifier: BSD-3-Clause
// The modes of forces with several (stops, joint friction), held from one event to the next. The mode of a stop follows
// from the state; that of friction is remembered, and changes at events.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "dynamics/dynamics.h"
#include "event/event_log.h"
#include "event/event_source.h"
#include "util/archive.h"

namespace gelenk {

// The equations of motion as EventModes needs them.
class ModeEquations {
 public:
  // vdot (nv) at (t, y) in the held modes, without effect on the run; `dynamics` is left there.
  virtual void accelerations_at(double t, const double* y, double* vdot) = 0;
  // Called when a remembered mode has changed.
  virtual void mode_changed() = 0;

 protected:
  ~ModeEquations() = default;
};

class EventModes final : public EventSource {
 public:
  // nq, nv: number of coordinates and velocities in y. log: receives the events.
  EventModes(ModeEquations& equations, Dynamics& dynamics, int nq, int nv, EventLog& log);

  // Two indicators for each force with modes. A stop: for its upper and its lower bound, positive while it is engaged.
  // Friction: of motion in the positive and in the negative direction, positive during it.
  int indicators() const override { return 2 * static_cast<int>(sides_.size()); }
  void indicator_values(double t, const double* y, double* g, double* gdot) override;
  void recall_mode(double t, const double* y) override;
  void remembered_mode(bool* positive) const override;
  void hold_mode(double t, const bool* positive) override;
  double mode_exit_time() const override { return mode_exit_time_; }
  void found_event(double t, int indicator, bool positive) override;
  void change_mode(double t, double* y) override;
  std::string too_many_events() const override { return log_.too_many(); }

  // Records whether an evaluation at t with velocities v, at the position of `dynamics`, is outside the held mode.
  void watch(double t, const double* v) {
    if (held_ && t > held_from_ && t < mode_exit_time_) check(t, v);
  }
  // The same after the accelerations have been solved for: whether friction cannot hold what it keeps at rest.
  void watch_holding_forces(double t) {
    if (held_ && any_at_rest_ && t > held_from_ && t < mode_exit_time_ && !forces_.is_redundant() &&
        are_exceeded(forces_.holding_forces()))
      mode_exit_time_ = t;
  }

  // Whether any mode is remembered.
  bool remembers() const { return !modes_.empty(); }
  // Determines the remembered modes from the state alone.
  void start(double t, const double* y);
  // Call when inputs have jumped.
  void inputs_jumped() { jumped_ = true; }
  // Friction without effect until start().
  void release();
  // Enters the modes that a step at (t, y) would begin in, without recording it.
  void preview(double t, const double* y);
  // The remembered modes: 1, -1: motion in this direction; 0: at rest.
  const std::vector<int>& modes() const { return modes_; }
  void set_modes(const std::vector<int>& modes);
  // Number of modes that were not unique.
  long ambiguous() const { return ambiguous_; }
  void serialize(Archive& archive);

 private:
  void check(double t, const double* v);
  bool is_outside();
  void hold_modes();
  void update_modes(double t, const double* y, bool jumped, bool logs);
  bool settle(double t, const double* y, bool breaks_away, bool logs);
  void force_away(double t);
  void enter(double t, const std::vector<int>& modes, bool logs);
  void find_holding_forces(double t, const double* y);
  bool are_exceeded(const std::vector<double>& holding_forces) const;
  std::vector<int> at_rest() const;

  ModeEquations& equations_;
  Dynamics& dynamics_;
  Branching& forces_;
  int nq_;
  EventLog& log_;
  std::vector<int> sides_, present_sides_;  // of the forces: held, and those of the present state
  std::vector<double> g_, gdot_;            // indicators
  bool held_ = false;                       // a mode is held
  double held_from_ = 0;                    // s: start of the held mode
  double mode_exit_time_ = INFINITY;        // s: see EventSource
  std::vector<int> modes_;                  // remembered, by lock
  std::vector<char> triggered_;             // by lock: an indicator has changed its sign
  std::vector<double> holding_;             // by lock: the force that keeps it at rest
  std::vector<double> vdot_;
  bool any_at_rest_ = false;
  bool jumped_ = false;
  long ambiguous_ = 0;
};

// During its lifetime the modes are those in which a step at (t, y) would begin with the present inputs; reading
// outputs does not change the run.
class FrictionPreview {
 public:
  FrictionPreview(EventModes& modes, double t, const double* y) : modes_(modes), before_(modes.modes()) {
    if (modes_.remembers()) modes_.preview(t, y);
  }
  ~FrictionPreview() {
    if (modes_.remembers()) modes_.set_modes(before_);
  }
  FrictionPreview(const FrictionPreview&) = delete;
  FrictionPreview& operator=(const FrictionPreview&) = delete;

 private:
  EventModes& modes_;
  std::vector<int> before_;
};

}  // namespace gelenk
