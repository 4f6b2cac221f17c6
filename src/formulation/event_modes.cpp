// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/event_modes.h"

namespace gelenk {

EventModes::EventModes(Dynamics& dynamics, int nq, EventLog& log)
    : dynamics_(dynamics),
      nq_(nq),
      log_(log),
      sides_(static_cast<std::size_t>(dynamics.branching().count())),
      present_sides_(sides_.size()),
      g_(2 * sides_.size()),
      gdot_(g_.size()) {}

void EventModes::indicator_values(const double* y, double* g, double* gdot) {
  dynamics_.set_position(y);
  dynamics_.set_velocity(y + nq_);
  dynamics_.branching().indicators(g, gdot);
}

void EventModes::hold_mode(double t, const bool* positive) {
  held_ = positive != nullptr;
  held_from_ = t;
  mode_exit_time_ = INFINITY;
  if (held_) {
    for (int& side : sides_) {
      side = positive[0] ? 1 : positive[1] ? -1 : 0;
      positive += 2;
    }
  }
  dynamics_.branching().hold(held_ ? sides_.data() : nullptr);
}

void EventModes::check(double t, const double* v) {
  dynamics_.set_velocity(v);
  dynamics_.branching().sides(present_sides_.data());
  if (present_sides_ != sides_ && is_outside()) mode_exit_time_ = t;
}

// At the boundary of the mode a state belongs to either side, as rounding decides.
bool EventModes::is_outside() {
  dynamics_.branching().indicators(g_.data(), gdot_.data());
  for (std::size_t i = 0; i < g_.size(); ++i) {
    const bool held = sides_[i / 2] == (i % 2 == 0 ? 1 : -1);
    if (held ? g_[i] < 0 : g_[i] > 0) return true;
  }
  return false;
}

}  // namespace gelenk
