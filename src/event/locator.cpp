// SPDX-License-Identifier: BSD-3-Clause
#include "event/locator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "math/bracket.h"

namespace gelenk {
namespace {

// Of the step. A force that jumps acts so much too long or too short, beside what it does in the step less than any
// tolerance.
constexpr double nearest_share = 1e-13;
// s, as near as times can be told apart.
double rounding(double t) { return 4 * std::numeric_limits<double>::epsilon() * std::abs(t); }
// Of steps made again; halving alone takes 44.
constexpr int most_trials = 60;
// Steps made shorter for loops to close at their end.
constexpr int most_shortened = 20;
// And in search of a touch that begins and ends within one. Some alarms are false: an implicit method asks for the
// equations at iterates that its stages then leave. The step made in the end is short, and right.
constexpr int most_alarms = 4;

}  // namespace

Locator::Locator(EventSource& source, int size) : source_(source), course_(source) {
  if (course_.size() == 0) return;
  start_y_.resize(static_cast<std::size_t>(size));
  high_y_.resize(static_cast<std::size_t>(size));
}

void Locator::keep_start(const Stepping& method) {
  std::copy_n(method.state(), start_y_.size(), start_y_.begin());
  course_.begin(method.time(), start_y_.data());
}

void Locator::keep_high(const Stepping& method) {
  high_t_ = method.time();
  std::copy_n(method.state(), high_y_.size(), high_y_.begin());
}

Step Locator::step(Stepping& method, double end) {
  stop_ = end;
  const Step step = step_in_mode(method, end);
  if (stop_ != end) method.stop_at(end);
  return step;
}

Step Locator::step_across(Stepping& method, double end) {
  keep_start(method);
  const Step step = method.step_towards(end);
  if (step != Step::made) return step;
  course_.end(method.time(), method.state());
  for (std::size_t i = 0; i < course_.size(); ++i) {
    if (course_.changed(i)) source_.found_event(course_.zero(i), static_cast<int>(i), course_.positive(i));
  }
  return source_.too_many_events().empty() ? Step::made : Step::too_many_events;
}

Step Locator::step_in_mode(Stepping& method, double end) {
  keep_start(method);
  const HeldMode held(source_, course_.start(), course_.mode());
  const bool approaches = course_.start() < approached_ && approached_ < end;
  if (approaches) stop_at(approached_, method);
  Step step = method.step_towards(stop_);
  // A mode may lead to where loops cannot be closed; the run leaves it before.
  for (int k = 0; k < most_shortened && step == Step::not_closed && has_left_mode(end); ++k) {
    step = step_from_start(method, source_.left_mode());
  }
  if (step != Step::made) return step;
  course_.end(method.time(), method.state());
  for (int k = 0; k < most_alarms && !course_.any_changed(); ++k) {
    const double touch = has_left_mode(method.time()) ? source_.left_mode() : course_.touch();
    if (!(touch < method.time())) return step;
    step = step_from_start(method, touch);
    if (step != Step::made) return step;
  }
  if (!course_.any_changed()) return step;
  keep_high(method);
  for (std::size_t i = 0; i < course_.size(); ++i) {
    if (!course_.changed(i)) continue;
    step = search(i, method);
    if (step != Step::made || !course_.any_changed()) return step;
  }
  return arrive(method);
}

void Locator::stop_at(double end, Stepping& method) {
  stop_ = end;
  method.stop_at(end);
}

// Whether the step has asked for the equations beyond an event, before `end`.
bool Locator::has_left_mode(double end) const {
  const double left = source_.left_mode();
  return left < end && left > course_.start() + rounding(end);
}

// Makes the step again, to `end` or less far.
Step Locator::step_from_start(Stepping& method, double end) {
  source_.hold_mode(course_.start(), course_.mode());
  method.go_to(course_.start(), start_y_.data());
  stop_at(end, method);
  const Step step = method.step_towards(end);
  if (step == Step::made) course_.end(method.time(), method.state());
  return step;
}

// Of a step that has gone beyond a zero of indicator i: leaves the earliest end known that lies beyond it, by a
// rounding or so, in high_y_; or the method where the error test has cut it short before, without a change.
Step Locator::search(std::size_t i, Stepping& method) {
  Bracket bracket(course_.start(), course_.at_start(i), high_t_, course_.at_end(i));
  const double nearest = std::max(nearest_share * (high_t_ - course_.start()), rounding(high_t_));
  double next = bracket.clamped(course_.zero(i), nearest);
  for (int k = 0; k < most_trials && bracket.width() > 2 * nearest; ++k) {
    if (const Step step = step_from_start(method, next); step != Step::made) return step;
    const double t = method.time();
    if (!(t > bracket.low() && t < bracket.high())) {
      if (course_.any_changed()) keep_high(method);  // another event, before
      approached_ = next;
      return Step::made;
    }
    if (course_.changed(i)) keep_high(method);
    bracket.update(t, course_.at_end(i));
    next = bracket.next(nearest);
  }
  course_.end(high_t_, high_y_.data());
  return Step::made;
}

// At the earliest event found: the next step begins there, a rounding beyond it.
Step Locator::arrive(Stepping& method) {
  for (std::size_t i = 0; i < course_.size(); ++i) {
    if (course_.changed(i)) source_.found_event(high_t_, static_cast<int>(i), course_.positive(i));
  }
  method.go_to(high_t_, high_y_.data());
  stop_ = high_t_;
  return source_.too_many_events().empty() ? Step::made : Step::too_many_events;
}

}  // namespace gelenk
