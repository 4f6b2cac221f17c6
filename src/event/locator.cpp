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
// By how much an indicator may come nearer to zero than its cubic says, as a share of the way that it comes.
constexpr double cubic_share = 0.05;
// Of the step: nearer to its ends there is nothing more to be seen than there.
constexpr double nearest_to_end = 1e-3;

}  // namespace

Locator::Locator(EventSource& source, int size) : source_(source) {
  const auto n = static_cast<std::size_t>(source.indicators());
  if (n == 0) return;
  for (auto* values : {&start_g_, &start_gdot_, &g_, &gdot_}) values->resize(n);
  start_positive_ = std::make_unique<bool[]>(n);
  positive_ = std::make_unique<bool[]>(n);
  start_y_.resize(static_cast<std::size_t>(size));
  high_y_.resize(static_cast<std::size_t>(size));
}

bool Locator::any_changed() const {
  return !std::equal(positive_.get(), positive_.get() + g_.size(), start_positive_.get());
}

void Locator::keep_start(const Stepping& method) {
  start_t_ = method.time();
  std::copy_n(method.state(), start_y_.size(), start_y_.begin());
  read_mode(source_, start_y_.data(), start_g_, start_gdot_, start_positive_.get());
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
  read_mode(source_, method.state(), g_, gdot_, positive_.get());
  for (std::size_t i = 0; i < g_.size(); ++i) {
    if (changed(i)) source_.found_event(estimate(i, method.time()), static_cast<int>(i), positive_[i]);
  }
  return source_.too_many_events().empty() ? Step::made : Step::too_many_events;
}

Step Locator::step_in_mode(Stepping& method, double end) {
  keep_start(method);
  const HeldMode held(source_, start_t_, start_positive_.get());
  const bool approaches = start_t_ < approached_ && approached_ < end;
  if (approaches) stop_at(approached_, method);
  Step step = method.step_towards(stop_);
  // A mode may lead to where loops cannot be closed; the run leaves it before.
  for (int k = 0; k < most_shortened && step == Step::not_closed && has_left_mode(end); ++k) {
    step = step_from_start(method, source_.left_mode());
  }
  if (step != Step::made) return step;
  read_mode(source_, method.state(), g_, gdot_, positive_.get());
  for (int k = 0; k < most_alarms && !any_changed(); ++k) {
    const double touch = has_left_mode(method.time()) ? source_.left_mode() : time_of_touch(method.time());
    if (!(touch < method.time())) return step;
    step = step_from_start(method, touch);
    if (step != Step::made) return step;
  }
  if (!any_changed()) return step;
  keep_high(method);
  for (std::size_t i = 0; i < g_.size(); ++i) {
    if (!changed(i)) continue;
    step = search(i, method);
    if (step != Step::made || !any_changed()) return step;
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
  return left < end && left > start_t_ + rounding(end);
}

// Makes the step again, to `end` or less far.
Step Locator::step_from_start(Stepping& method, double end) {
  source_.hold_mode(start_t_, start_positive_.get());
  method.go_to(start_t_, start_y_.data());
  stop_at(end, method);
  const Step step = method.step_towards(end);
  if (step == Step::made) read_mode(source_, method.state(), g_, gdot_, positive_.get());
  return step;
}

// Of a step that has gone beyond a zero of indicator i: leaves the earliest end known that lies beyond it, by a
// rounding or so, in high_y_; or the method where the error test has cut it short before, without a change.
Step Locator::search(std::size_t i, Stepping& method) {
  Bracket bracket(start_t_, start_g_[i], high_t_, g_[i]);
  const double nearest = std::max(nearest_share * (high_t_ - start_t_), rounding(high_t_));
  double next = bracket.kept(estimate(i, high_t_), nearest);
  for (int k = 0; k < most_trials && bracket.width() > 2 * nearest; ++k) {
    if (const Step step = step_from_start(method, next); step != Step::made) return step;
    const double t = method.time();
    if (!(t > bracket.low() && t < bracket.high())) {
      if (any_changed()) keep_high(method);  // another event, before
      approached_ = next;
      return Step::made;
    }
    if (changed(i)) keep_high(method);
    bracket.put(t, g_[i]);
    next = bracket.next(nearest);
  }
  read_mode(source_, high_y_.data(), g_, gdot_, positive_.get());
  return Step::made;
}

// At the earliest event found: the next step begins there, a rounding beyond it.
Step Locator::arrive(Stepping& method) {
  for (std::size_t i = 0; i < g_.size(); ++i) {
    if (changed(i)) source_.found_event(high_t_, static_cast<int>(i), positive_[i]);
  }
  method.go_to(high_t_, high_y_.data());
  stop_ = high_t_;
  return source_.too_many_events().empty() ? Step::made : Step::too_many_events;
}

// Of an indicator in a step to t.
Cubic Locator::cubic(std::size_t i, double t) const {
  const double h = t - start_t_;
  return {start_g_[i], h * start_gdot_[i], g_[i], h * gdot_[i]};
}

// s
double Locator::estimate(std::size_t i, double t) const { return start_t_ + cubic(i, t).zero() * (t - start_t_); }

// s: where, in a step to t, an indicator may reach zero that has the same sign at both ends; infinite: nowhere.
double Locator::time_of_touch(double t) const {
  double first = INFINITY;
  for (std::size_t i = 0; i < g_.size(); ++i) {
    const bool approaches = start_positive_[i] ? start_gdot_[i] < 0 : start_gdot_[i] > 0;
    const Cubic course = cubic(i, t);
    if (!approaches || !course.turns()) continue;
    const double s = course.turning_point();
    const double nearest = start_positive_[i] ? course.value(s) : -course.value(s);
    const double way = std::max(std::abs(start_g_[i]), std::abs(g_[i])) - nearest;
    if (nearest > cubic_share * way || s < nearest_to_end || s > 1 - nearest_to_end) continue;
    first = std::min(first, start_t_ + s * (t - start_t_));
  }
  return first;
}

}  // namespace gelenk
