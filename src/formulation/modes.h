// SPDX-License-Identifier: BSD-3-Clause
// The mode of what has branches (stops): held from one event to the next.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "dynamics/dynamics.h"
#include "event/event_log.h"
#include "event/event_source.h"

namespace gelenk {

class Modes final : public EventSource {
 public:
  // nq: coordinates in y. log: where events are written.
  Modes(Dynamics& dynamics, int nq, EventLog& log);

  // Two for each stop, at its upper and its lower bound: positive where it pushes.
  int indicators() const override { return 2 * static_cast<int>(sides_.size()); }
  void indicator_values(const double* y, double* g, double* gdot) override;
  void hold_mode(double t, const bool* positive) override;
  double left_mode() const override { return left_mode_; }
  void found_event(double t, int indicator, bool positive) override { log_.add({t, indicator, positive}); }
  std::string too_many_events() const override { return log_.too_many(); }

  // Of an evaluation at t with speeds v, where `dynamics` stands: whether it is outside the mode.
  void watch(double t, const double* v) {
    if (held_ && t > held_from_ && t < left_mode_) look(t, v);
  }

 private:
  void look(double t, const double* v);
  bool is_beyond();

  Dynamics& dynamics_;
  int nq_;
  EventLog& log_;
  std::vector<int> sides_, present_;  // branches that are held, and those of a state
  std::vector<double> g_, gdot_;      // indicators
  bool held_ = false;                 // they are
  double held_from_ = 0;              // s
  double left_mode_ = INFINITY;       // s
};

}  // namespace gelenk
