// SPDX-License-Identifier: BSD-3-Clause
// Makes steps end at events. A step is made in the mode in which it began, so that the equations are smooth; if an
// indicator has changed sign, the step is repeated from its start to other ends until it ends at the event. The time of
// an event is therefore as accurate as the steps of the method.
#pragma once

#include <vector>

#include "event/event_source.h"
#include "event/step_course.h"
#include "event/step_polynomial.h"
#include "math/bracket.h"
#include "util/archive.h"

namespace gelenk {

enum class Step { made, too_small, not_finite, not_closed, stopped, refused };

// An integration method as the locator drives it.
class Stepping {
 public:
  virtual double time() const = 0;
  virtual const double* state() const = 0;
  // Makes one step to `end` or less far.
  virtual Step step_towards(double end) = 0;
  // Makes the next step begin at (t, y), where the equations may have changed.
  virtual void go_to(double t, const double* y) = 0;
  // Whether a step depends on nothing but its start: the repeated steps of other methods are more accurate.
  virtual bool is_one_step() const { return true; }
  // Length of the step that is tried next, if it can be chosen [s]; 0: not known.
  virtual double next_step() const { return 0; }
  // Makes the next step at least this long, as far as errors permit [s].
  virtual void lengthen_next_step(double /*step*/) {}
  // What its steps must be bounded for (EventSource::longest_step); by default nothing.
  virtual EventSource::SlowSliding slow_sliding() const { return {.followed_from = 0}; }
  // Sets the time [s] at which steps stop.
  virtual void stop_at(double end) = 0;

 protected:
  ~Stepping() = default;
};

class Locator {
 public:
  // size: number of components of y.
  Locator(EventSource& source, int size);

  bool is_needed() const { return course_.size() > 0 || source_.has_breaks(); }
  // Makes one step of the method to `end`, to the first event or break before it, or less far.
  Step step(Stepping& method, double end);
  // Makes one step that may extend across events, but not across breaks; events are reported at approximate times. For
  // methods that cannot make very short steps.
  Step step_across(Stepping& method, double end);
  // Call if the method continues from another state.
  void restart() { event_ahead_ = 0; }
  void serialize(Archive& archive) { archive.serialize(event_ahead_); }

 private:
  Step step_to_break(Stepping& method, double end, Step (Locator::*make)(Stepping&, double));
  Step step_alone(Stepping& method, double end);
  Step step_to_event(Stepping& method, double end);
  Step step_over_events(Stepping& method, double end);
  Step step_in_mode(Stepping& method, double end);
  void bound_step(Stepping& method);
  // Whether the step has been ended for good.
  struct Trial {
    Step step;
    bool is_last;
  };
  Step end_step(Stepping& method);
  Trial end_without_event(Stepping& method);
  Trial end_before_event(Stepping& method);
  bool is_before(double t, double end) const;
  double resolution_to(double end) const;
  bool is_resolved(double end) const;
  double touch_within(double end, const double* y) const;
  Step search_all(Stepping& method);
  std::size_t next_to_search() const;
  bool any_impact() const;
  Step search(std::size_t i, Stepping& method);
  bool search_within_step(std::size_t i);
  double next_trial(std::size_t i, const Bracket& bracket, bool converges, double resolution) const;
  Step repeat_step(Stepping& method, double end);
  bool drift_to(double end, double resolved, std::size_t i, const Stepping& method);
  bool has_left_mode(double end) const;
  void save_start(Stepping& method, double end);
  void save_high(const Stepping& method);
  Step end_at_event(Stepping& method);
  void stop_at(double end, Stepping& method);

  EventSource& source_;
  double end_ = 0;          // s: end of the step asked for
  double stop_ = 0;         // s: time at which the steps of the method stop
  double next_step_ = 0;    // s: length of the step that the method would make
  double event_ahead_ = 0;  // s: approximate time of an event that several steps approach
  StepCourse course_;
  StepPolynomial polynomial_;  // of the step beyond an event
  bool is_polynomial_accurate_ = false;
  // The earliest known end of a step that lies beyond an event.
  double high_t_ = 0;
  std::vector<double> start_y_, high_y_, trial_y_;
  std::vector<char> searched_;  // by indicator
};

}  // namespace gelenk
