// SPDX-License-Identifier: BSD-3-Clause
// Decides between located events, which keep the tolerance where few shapes touch, and steps with impulses, which bear
// many contacts, by what contacts between shapes do: neither events of joints nor stiffness count, since steps with
// impulses are no remedy for these. Where the two cost the same, and how much more events may cost, since they are more
// accurate by orders of magnitude, was measured: see docs/nonsmooth-measurements.md.
#pragma once

#include <algorithm>
#include <cmath>

#include "event/event_log.h"
#include "util/archive.h"

namespace gelenk {

class SchemeWatch {
 public:
  // Points of contact beyond which events are left, and up to which they are returned to.
  static constexpr int most_closed = 16;
  static constexpr int least_closed = 12;
  // Events of contacts between shapes that count, those of the last steps of 1 ms (of time stepping), older ones less
  // and less; and the largest number. A ball that comes to rest with a coefficient of restitution of 0.9 makes 70 of
  // its 106 impacts within that time. Longer steps do not count as such: they could not resolve so many events.
  static constexpr double longest_counted = 1e-3;  // s
  static constexpr double memory = 200;            // steps
  static constexpr double most_events = 100;
  // Steps without changes after which events are returned to, and the most, after repeated returns of short duration.
  static constexpr double least_quiet = 50;
  static constexpr double most_quiet = 3200;

  // step: of time stepping [s].
  explicit SchemeWatch(double step) : step_(step), counted_(std::min(step, longest_counted)) {}

  // Call after events were located for a time [s]; events: those of contacts between shapes.
  void located(double time, long events) {
    const double steps = time / counted_;
    events_ = std::exp(-steps / memory) * events_ + static_cast<double>(events);
    since_return_ = std::min(since_return_ + time / step_, memory);
  }
  // Why to leave events; `none`: there is no reason.
  SchemeChange::Cause too_many(int closed) const {
    if (closed > most_closed) return SchemeChange::Cause::closed_points;
    return events_ > most_events ? SchemeChange::Cause::contact_events : SchemeChange::Cause::none;
  }
  // Call where steps begin.
  void leave_events() {
    quiet_needed_ = since_return_ < memory ? std::min(2 * quiet_needed_, most_quiet) : least_quiet;
    quiet_ = 0;
  }
  // Call after steps with impulses for a time [s], during which contacts have changed or not.
  void stepped(double time, bool changed, int closed) {
    quiet_ = changed || closed > least_closed ? 0 : std::min(quiet_ + time / step_, most_quiet);
  }
  // Whether to return to events.
  bool is_quiet() const { return quiet_ >= quiet_needed_ - rounding; }
  // Call where events begin again.
  void return_to_events() { events_ = since_return_ = 0; }

  void serialize(Archive& archive) { archive.serialize(events_, since_return_, quiet_, quiet_needed_); }

 private:
  static constexpr double rounding = 1e-6;  // of sums of times, in steps

  double step_, counted_;
  double events_ = 0;
  double since_return_ = memory;  // steps; the start of a run is no return
  double quiet_ = 0, quiet_needed_ = least_quiet;
};

}  // namespace gelenk
