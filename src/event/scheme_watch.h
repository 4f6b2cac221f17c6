// SPDX-License-Identifier: BSD-3-Clause
// Decides between located events, which are exact where few shapes touch, and steps with impulses, which bear many, by
// what happens. Where the two cost the same, and how much more events may cost, since they are more accurate by orders
// of magnitude, was measured: see docs/contact.md.
#pragma once

#include <algorithm>
#include <cmath>

#include "util/archive.h"

namespace gelenk {

class SchemeWatch {
 public:
  // Points of contact beyond which events are left, and up to which they are returned to.
  static constexpr int most_closed = 16;
  static constexpr int least_closed = 12;
  // Events and evaluations of the equations that count, those of the last steps (of time stepping), older ones less and
  // less; and the largest numbers. A ball that comes to rest with a coefficient of restitution of 0.9 makes 70 of its
  // 106 impacts within that time.
  static constexpr double memory = 200;  // steps
  static constexpr double most_events = 100;
  static constexpr double most_evaluations = 30'000;
  // Steps without changes after which events are returned to, and the most, after repeated returns of short duration.
  static constexpr int least_quiet = 50;
  static constexpr int most_quiet = 3200;

  // Call after events were located for a time, in steps.
  void located(double steps, long events, long evaluations) {
    const double left = std::exp(-steps / memory);
    events_ = left * events_ + static_cast<double>(events);
    evaluations_ = left * evaluations_ + static_cast<double>(evaluations);
    since_return_ = std::min(since_return_ + steps, memory);
  }
  bool are_too_many(int closed) const {
    return closed > most_closed || events_ > most_events || evaluations_ > most_evaluations;
  }
  // Call where steps begin.
  void leave_events() {
    quiet_needed_ = since_return_ < memory ? std::min(2 * quiet_needed_, most_quiet) : least_quiet;
    quiet_ = 0;
  }
  // Call after steps with impulses, during which contacts have changed or not. Returns whether to return to events.
  bool stepped(int steps, bool changed, int closed) {
    quiet_ = changed || closed > least_closed ? 0 : std::min(quiet_ + steps, most_quiet);
    return quiet_ >= quiet_needed_;
  }
  // Call where events begin again.
  void return_to_events() { events_ = evaluations_ = since_return_ = 0; }

  void serialize(Archive& archive) {
    archive.serialize(events_, evaluations_, since_return_);
    archive.serialize_in_range(quiet_, 0, most_quiet);
    archive.serialize_in_range(quiet_needed_, least_quiet, most_quiet);
  }

 private:
  double events_ = 0, evaluations_ = 0;
  double since_return_ = memory;  // steps; the start of a run is no return
  int quiet_ = 0, quiet_needed_ = least_quiet;
};

}  // namespace gelenk
