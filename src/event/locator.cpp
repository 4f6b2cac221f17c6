// SPDX-License-Identifier: BSD-3-Clause
#include "event/locator.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gelenk {
namespace {

// Resolution of event times relative to the step. A discontinuous force acts too long or too short by this time, with
// an effect far below any tolerance.
constexpr double resolution_fraction = 5e-14;
// Resolution of times near t [s].
double rounding(double t) { return 4 * std::numeric_limits<double>::epsilon() * std::abs(t); }
// A step by the rate of an indicator is trusted where the one before has left this part of its value.
constexpr double newton_progress = 0.1;
// Part of a step of which the square is rounding, relative to what changes in the step.
constexpr double negligible_square = 1e-7;
// Limit on repeated steps; bisection alone needs 44.
constexpr int max_trials = 60;
// The same within the polynomial of a step, by Newton's method.
constexpr int max_trials_within = 10;
// Limit on steps shortened because loops did not close at their end.
constexpr int max_shortened_steps = 20;
// Limit on steps repeated to find a contact that begins and ends within a step. Some trials are false alarms: an
// implicit method evaluates the equations at iterates that its stages do not converge to. The step made in the end is
// short, but correct.
constexpr int max_touch_trials = 8;
// Relative to times: shorter ones are not stepped over.
constexpr double shortest_stretch = 1e-14;
// In units of the resolution of times: within a shorter step, times cannot be distinguished.
constexpr double shortest_course = 1e4;

}  // namespace

Locator::Locator(EventSource& source, int size) : source_(source), course_(source), polynomial_(size) {
  start_y_.resize(static_cast<std::size_t>(size));
  high_y_.resize(static_cast<std::size_t>(size));
  trial_y_.resize(static_cast<std::size_t>(size));
  searched_.resize(course_.size());
}

// end: of the step to come.
void Locator::save_start(Stepping& method, double end) {
  std::copy_n(method.state(), start_y_.size(), start_y_.begin());
  next_step_ = method.next_step();
  if (!course_.begin(method.time(), start_y_.data())) return;
  method.go_to(method.time(), start_y_.data());
  method.stop_at(end);
}

void Locator::save_high(const Stepping& method) {
  high_t_ = method.time();
  std::copy_n(method.state(), high_y_.size(), high_y_.begin());
}

Step Locator::step(Stepping& method, double end) { return step_to_break(method, end, &Locator::step_to_event); }

Step Locator::step_across(Stepping& method, double end) {
  return step_to_break(method, end, &Locator::step_over_events);
}

// Makes a step to `end` or to the next break before it.
Step Locator::step_to_break(Stepping& method, double end, Step (Locator::*make)(Stepping&, double)) {
  if (!source_.has_breaks()) return (this->*make)(method, end);
  // A break at the beginning has been passed, and one at the end is there: no method can step from one to the other.
  const double near = shortest_stretch * std::max(std::abs(method.time()), std::abs(end));
  const double ahead = source_.next_break(method.time() + near);
  const bool meets_break = ahead <= end + near;
  const double stop = ahead < end - near ? ahead : end;
  if (stop != end) method.stop_at(stop);
  source_.begin_stretch(method.time(), ahead);
  const Step step = (this->*make)(method, stop);
  source_.begin_stretch(NAN, NAN);
  if (step == Step::made && meets_break && method.time() == stop) {
    source_.pass_break();
    std::copy_n(method.state(), high_y_.size(), high_y_.begin());
    method.go_to(stop, high_y_.data());
    method.lengthen_next_step(next_step_);
    method.stop_at(end);
  } else if (stop != end) {
    method.stop_at(end);
  }
  return step;
}

// Where there are no events.
Step Locator::step_alone(Stepping& method, double end) {
  next_step_ = method.next_step();
  return method.step_towards(end);
}

Step Locator::step_to_event(Stepping& method, double end) {
  if (course_.size() == 0) return step_alone(method, end);
  stop_ = end_ = end;
  const Step step = step_in_mode(method, end);
  if (stop_ != end) method.stop_at(end);
  return step;
}

Step Locator::step_over_events(Stepping& method, double end) {
  if (course_.size() == 0) return step_alone(method, end);
  save_start(method, end);
  if (!source_.refusal().empty()) return Step::refused;
  const Step step = method.step_towards(end);
  if (step != Step::made) return step;
  course_.end(method.time(), method.state());
  for (std::size_t i = 0; i < course_.size(); ++i) {
    if (course_.changed(i)) source_.found_event(course_.zero(i), static_cast<int>(i), course_.positive(i));
  }
  return source_.refusal().empty() ? Step::made : Step::refused;
}

Step Locator::step_in_mode(Stepping& method, double end) {
  save_start(method, end);
  if (!source_.refusal().empty()) return Step::refused;
  const HeldMode held(source_, course_.start(), course_.mode());
  const bool approaches = course_.start() < event_ahead_ && event_ahead_ < end;
  if (approaches) stop_at(event_ahead_, method);
  bound_step(method);
  Step step = method.step_towards(stop_);
  // In the held mode the loops may become impossible to close beyond the event; the step is shortened to before it.
  for (int k = 0; k < max_shortened_steps && step == Step::not_closed && has_left_mode(end); ++k) {
    step = repeat_step(method, source_.mode_exit_time());
  }
  if (step != Step::made) return step;
  course_.end(method.time(), method.state());
  return end_step(method);
}

// Shortens the step to come where friction would turn too fast for the method.
void Locator::bound_step(Stepping& method) {
  const EventSource::SlowSliding by = method.slow_sliding();
  if (!(by.followed_from > 0)) return;
  const double start = course_.start();
  const double longest = start + source_.longest_step(start, start_y_.data(), by);
  if (longest < stop_ - rounding(stop_)) stop_at(longest, method);
}

// After a step: ends it at the earliest event within it, if there is one. A mode may also have ended and begun again
// within the step, or before the event at which it ends.
Step Locator::end_step(Stepping& method) {
  for (int k = 0; k < max_touch_trials; ++k) {
    const Trial trial = course_.any_changed() ? end_before_event(method) : end_without_event(method);
    if (trial.is_last) return trial.step;
  }
  if (!course_.any_changed()) return Step::made;
  const Step step = search_all(method);
  return step == Step::made && course_.any_changed() ? end_at_event(method) : step;
}

Locator::Trial Locator::end_without_event(Stepping& method) {
  const double end = method.time();
  double touch = has_left_mode(end) ? source_.mode_exit_time() : course_.touch(course_.size());
  if (is_resolved(end)) touch = std::min(touch, touch_within(end, method.state()));
  if (!is_before(touch, end)) return {Step::made, true};
  const Step step = repeat_step(method, touch);
  return {step, step != Step::made};
}

Locator::Trial Locator::end_before_event(Stepping& method) {
  if (const Step step = search_all(method); step != Step::made) return {step, true};
  const auto smooth = static_cast<std::size_t>(source_.smooth_indicators());
  if (!course_.any_changed()) {
    const double end = method.time();
    const bool touches =
        is_resolved(end) && is_before(std::min(course_.touch(smooth), touch_within(end, method.state())), end);
    return {Step::made, smooth < course_.size() && !touches};
  }
  double touch = course_.touch(smooth);
  if (is_resolved(high_t_)) touch = std::min(touch, touch_within(high_t_, high_y_.data()));
  if (!is_before(touch, high_t_)) return {end_at_event(method), true};
  if (const Step step = repeat_step(method, touch); step != Step::made) return {step, true};
  if (course_.any_changed()) return {Step::made, false};
  course_.end(high_t_, high_y_.data());
  return {end_at_event(method), true};
}

// Whether a time can be distinguished from the start and the end of a step, which is not too short for that.
bool Locator::is_before(double t, double end) const {
  return t < end - rounding(end) && t > course_.start() + resolution_to(end) && is_resolved(end);
}

// Of event times within a step to `end`.
double Locator::resolution_to(double end) const {
  return std::max(resolution_fraction * (end - course_.start()), rounding(end));
}

// The time at the end of the communication step decides, since near 0 any step would be long enough.
bool Locator::is_resolved(double end) const {
  return end - course_.start() > shortest_course * rounding(std::max(std::abs(end), std::abs(end_)));
}

// See EventSource; after the end of the step has been set.
double Locator::touch_within(double end, const double* y) const {
  return source_.touch_within(course_.start(), start_y_.data(), end, y);
}

// After a step beyond zeros of indicators: leaves the earliest end beyond one of them in high_y_.
Step Locator::search_all(Stepping& method) {
  save_high(method);
  std::ranges::fill(searched_, 0);
  is_polynomial_accurate_ = method.is_one_step() && is_resolved(high_t_) && any_impact() &&
                            polynomial_.set(source_, course_.start(), start_y_.data(), high_t_, high_y_.data());
  // Before an event, others may be beyond a zero from which they had returned at the end of the step.
  for (std::size_t i = next_to_search(); i < course_.size(); i = next_to_search()) {
    searched_[i] = 1;
    if (is_polynomial_accurate_ && source_.is_of_impact(static_cast<int>(i)) && search_within_step(i)) continue;
    const Step step = search(i, method);
    if (step != Step::made || !course_.any_changed()) return step;
  }
  return Step::made;
}

// Of the indicators that have changed and are smooth, the one that seems to be the first: a step may cross many points
// of a table. Of others, the first in number.
std::size_t Locator::next_to_search() const {
  const auto smooth = static_cast<std::size_t>(source_.smooth_indicators());
  std::size_t out = course_.size();
  double first = NAN;  // s: zero of that indicator, if there are others
  for (std::size_t i = 0; i < course_.size(); ++i) {
    if (searched_[i] != 0 || !course_.changed(i)) continue;
    if (i >= smooth) return std::min(i, out);
    if (out == course_.size()) {
      out = i;
      continue;
    }
    if (std::isnan(first)) first = course_.zero(out);
    if (const double zero = course_.zero(i); zero < first) {
      out = i;
      first = zero;
    }
  }
  return out;
}

// Whether something strikes at one of the zeros.
bool Locator::any_impact() const {
  for (std::size_t i = 0; i < course_.size(); ++i) {
    if (course_.changed(i) && source_.is_of_impact(static_cast<int>(i))) return true;
  }
  return false;
}

void Locator::stop_at(double end, Stepping& method) {
  stop_ = end;
  method.stop_at(end);
}

// Whether the step has evaluated the equations beyond an event before `end`.
bool Locator::has_left_mode(double end) const {
  const double left = source_.mode_exit_time();
  return left < end && left > course_.start() + resolution_to(end);
}

// Repeats the step, to `end` or less far.
Step Locator::repeat_step(Stepping& method, double end) {
  source_.hold_mode(course_.start(), course_.mode());
  method.go_to(course_.start(), start_y_.data());
  stop_at(end, method);
  const Step step = method.step_towards(end);
  if (step == Step::made) course_.end(method.time(), method.state());
  return step;
}

// search() by the polynomial of the step instead of repeated steps. Returns false, with the course as before, if it
// does not converge.
bool Locator::search_within_step(std::size_t i) {
  const StepCourse::Search searched(course_, i);
  Bracket bracket(course_.start(), course_.at_start(i), high_t_, course_.at_end(i));
  const double resolution = resolution_to(high_t_);
  double next = bracket.clamped(course_.zero(i), resolution);
  double least = INFINITY;  // of the indicator's values
  for (int k = 0; k < max_trials_within; ++k) {
    polynomial_.at(next, trial_y_.data());
    source_.normalize(trial_y_.data());
    course_.end(next, trial_y_.data());
    const double g = course_.at_end(i);
    if (course_.changed(i) && std::abs(g) <= indicator_rounding) {
      high_t_ = next;
      high_y_ = trial_y_;
      return true;
    }
    bracket.update(next, g);
    if (bracket.width() <= 2 * resolution) break;
    next = next_trial(i, bracket, std::abs(g) <= newton_progress * least, resolution);
    least = std::min(least, std::abs(g));
  }
  course_.end(high_t_, high_y_.data());
  return false;
}

// The end to try next: beyond the zero by rounding, as the rate of the indicator at the end of the last trial says, if
// it is known and that trial has come closer (converges); otherwise by the values alone.
double Locator::next_trial(std::size_t i, const Bracket& bracket, bool converges, double resolution) const {
  const double zero = course_.end() - course_.at_end(i) / course_.rate_at_end(i) + resolution / 2;
  const bool is_inside = zero > bracket.low() && zero < bracket.high();
  return converges && is_inside ? bracket.clamped(zero, resolution) : bracket.next(resolution);
}

// After a step beyond a zero of indicator i: finds the earliest end beyond the zero, within rounding, and leaves it in
// high_y_; or leaves the method at an earlier end without a sign change if the error test has cut the step short.
Step Locator::search(std::size_t i, Stepping& method) {
  const StepCourse::Search searched(course_, i);
  Bracket bracket(course_.start(), course_.at_start(i), high_t_, course_.at_end(i));
  const double resolution = resolution_to(high_t_);
  double next = bracket.clamped(course_.zero(i), resolution);
  const double resolved = high_t_ - course_.start();  // by the method, in a single step
  double least = INFINITY;                            // of the indicator's values
  for (int k = 0; k < max_trials && bracket.width() > 2 * resolution; ++k) {
    if (const Step step = repeat_step(method, next); step != Step::made) return step;
    const double t = method.time();
    if (!(t > bracket.low() && t < bracket.high())) {
      if (course_.any_changed()) save_high(method);  // another, earlier event
      event_ahead_ = next;
      return Step::made;
    }
    if (course_.changed(i)) save_high(method);
    const double g = course_.at_end(i);
    bracket.update(t, g);
    if (course_.changed(i) && std::abs(g) <= indicator_rounding) break;
    next = next_trial(i, bracket, std::abs(g) <= newton_progress * least, resolution);
    if (drift_to(next, resolved, i, method)) break;
    least = std::min(least, std::abs(g));
  }
  course_.end(high_t_, high_y_.data());
  return Step::made;
}

// Where the next trial would end so near to the last one that the square of the time between does not matter, the state
// there follows from its rates, at a fraction of the cost of a step. Returns whether it is beyond the zero of indicator
// i, by no more than rounding; it is then in high_y_.
bool Locator::drift_to(double end, double resolved, std::size_t i, const Stepping& method) {
  const double t = method.time();
  if (!(std::abs(end - t) <= negligible_square * resolved)) return false;
  std::copy_n(method.state(), trial_y_.size(), trial_y_.begin());
  if (!source_.drift(t, trial_y_.data(), end - t)) return false;
  course_.end(end, trial_y_.data());
  if (!course_.changed(i) || std::abs(course_.at_end(i)) > indicator_rounding) return false;
  high_t_ = end;
  high_y_ = trial_y_;
  return true;
}

// Ends the step at the earliest event found, beyond it by rounding; the next step begins there.
Step Locator::end_at_event(Stepping& method) {
  for (std::size_t i = 0; i < course_.size(); ++i) {
    if (course_.changed(i)) source_.found_event(high_t_, static_cast<int>(i), course_.positive(i));
  }
  if (end_ - high_t_ <= rounding(end_)) high_t_ = end_;  // no method can make so short a step
  source_.change_mode(high_t_, high_y_.data());
  method.go_to(high_t_, high_y_.data());
  // Steps to an event may be as short as rounding; they would have to grow from there.
  method.lengthen_next_step(next_step_);
  stop_ = high_t_;
  return source_.refusal().empty() ? Step::made : Step::refused;
}

}  // namespace gelenk
