// SPDX-License-Identifier: BSD-3-Clause
// The mode of elements with several states (stops), held from one event to the next.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "dynamics/dynamics.h"
#include "event/event_log.h"
#include "event/event_source.h"

namespace gelenk {

class EventModes final : public EventSource {
 public:
  // nq: number of coordinates in y. log: receives the events.
  EventModes(Dynamics& dynamics, int nq, EventLog& log);

  // Two indicators for each stop, for its upper and its lower bound: positive while it is engaged.
  int indicators() const override { return 2 * static_cast<int>(sides_.size()); }
  void indicator_values(const double* y, double* g, double* gdot) override;
  void hold_mode(double t, const bool* positive) override;
  double mode_exit_time() const override { return mode_exit_time_; }
  void found_event(double t, int indicator, bool positive) override { log_.add({t, indicator, positive}); }
  std::string too_many_events() const override { return log_.too_many(); }

  // Records whether an evaluation at t with velocities v, at the position of `dynamics`, is outside the held mode.
  void watch(double t, const double* v) {
    if (held_ && t > held_from_ && t < mode_exit_time_) check(t, v);
  }

 private:
  void check(double t, const double* v);
  bool is_outside();

  Dynamics& dynamics_;
  int nq_;
  EventLog& log_;
  std::vector<int> sides_, present_sides_;  // sides of the stops: held, and those of the present state
  std::vector<double> g_, gdot_;            // indicators
  bool held_ = false;                       // a mode is held
  double held_from_ = 0;                    // s: start of the held mode
  double mode_exit_time_ = INFINITY;        // s: see EventSource
};

}  // namespace gelenk
