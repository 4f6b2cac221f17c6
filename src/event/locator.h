// SPDX-License-Identifier: BSD-3-Clause
// Steps end at events. A step keeps to the mode in which it began, so that it is as smooth as the method wants it; if
// an indicator has changed its sign in it, it is made again from where it began, to other ends, until it ends there. So
// the time of an event is as accurate as the method's steps are.
#pragma once

#include <vector>

#include "event/event_source.h"
#include "event/step_course.h"
#include "util/archive.h"

namespace gelenk {

enum class Step { made, too_small, not_finite, not_closed, stopped, too_many_events };

// A method of integration, as a locator drives it.
class Stepping {
 public:
  virtual double time() const = 0;
  virtual const double* state() const = 0;
  // One step, to `end` or less far.
  virtual Step step_towards(double end) = 0;
  // The next step begins at (t, y), where the equations may have changed.
  virtual void go_to(double t, const double* y) = 0;
  // Steps stop at `end` from now on.
  virtual void stop_at(double end) = 0;

 protected:
  ~Stepping() = default;
};

class Locator {
 public:
  // size: of y.
  Locator(EventSource& source, int size);

  bool is_needed() const { return source_.indicators() > 0; }
  // One step of the method, to `end`, to the first event before, or less far.
  Step step(Stepping& method, double end);
  // One step that ends where the method ends it, across events too, which are told at about their times: for methods
  // that can make no very short steps.
  Step step_across(Stepping& method, double end);
  // The method begins elsewhere.
  void restart() { approached_ = 0; }
  void serialize(Archive& archive) { archive.serialize(approached_); }

 private:
  Step step_in_mode(Stepping& method, double end);
  Step search(std::size_t i, Stepping& method);
  Step step_from_start(Stepping& method, double end);
  bool has_left_mode(double end) const;
  void keep_start(const Stepping& method);
  void keep_high(const Stepping& method);
  Step arrive(Stepping& method);
  void stop_at(double end, Stepping& method);

  EventSource& source_;
  double stop_ = 0;        // s: where the method's steps stop
  double approached_ = 0;  // s: about where an event is, to which several steps are made
  StepCourse course_;
  // The earliest end known to be beyond an event.
  double high_t_ = 0;
  std::vector<double> start_y_, high_y_;
};

}  // namespace gelenk
