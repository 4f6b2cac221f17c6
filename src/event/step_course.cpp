// SPDX-License-Identifier: BSD-3-Clause
#include "event/step_course.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gelenk {
namespace {

// Error of the cubic: an indicator may come nearer to zero than its cubic by this fraction of its approach.
constexpr double cubic_error_fraction = 0.05;
// Fraction of the step: an extremum nearer to an end is not resolved from it.
constexpr double min_end_distance = 1e-3;
// In place of a zero of which the sign is known.
constexpr double smallest = std::numeric_limits<double>::min();

// Rates up to this are rounding [natural units]: accelerations are sums of forces, some of them a thousand times as
// large. A true rate like this would need a millisecond to change an indicator by more than its rounding.
constexpr double rate_rounding = 1e-12;

// Whether an indicator neither has a value nor changes, but by rounding.
bool rests(double g, double gdot) { return std::abs(g) <= indicator_rounding && std::abs(gdot) <= rate_rounding; }

}  // namespace

StepCourse::StepCourse(EventSource& source) : source_(source) {
  const auto n = static_cast<std::size_t>(source.indicators());
  for (auto* values : {&start_g_, &start_gdot_, &g_, &gdot_}) values->resize(n);
  before_ = std::make_unique<bool[]>(n);
  after_ = std::make_unique<bool[]>(n);
}

bool StepCourse::begin(double t, double* y) {
  start_t_ = t;
  const bool changed = source_.recall_mode(t, y);
  read_mode(source_, t, y, start_g_, start_gdot_, before_.get());
  source_.remembered_mode(before_.get());
  // At the beginning of a mode an indicator is zero, or beyond it by rounding.
  for (std::size_t i = 0; i < size(); ++i) {
    if (start_g_[i] == 0 || (start_g_[i] > 0) != before_[i]) start_g_[i] = before_[i] ? smallest : -smallest;
  }
  return changed;
}

void StepCourse::end(double t, const double* y) {
  t_ = t;
  read_mode(source_, t, y, g_, gdot_, after_.get());
  // What rests although its own mode would let it move, as a joint with friction that a contact holds, changes its sign
  // by rounding in every step.
  for (std::size_t i = 0; i < size(); ++i) {
    if (i != searched_ && rests(start_g_[i], start_gdot_[i]) && rests(g_[i], gdot_[i])) after_[i] = before_[i];
  }
}

bool StepCourse::any_changed() const { return !std::equal(after_.get(), after_.get() + size(), before_.get()); }

double StepCourse::at_end(std::size_t i) const { return g_[i] != 0 ? g_[i] : after_[i] ? smallest : -smallest; }

Cubic StepCourse::cubic(std::size_t i) const {
  const double h = t_ - start_t_;
  return {start_g_[i], h * start_gdot_[i], g_[i], h * gdot_[i]};
}

double StepCourse::zero(std::size_t i) const { return start_t_ + cubic(i).zero() * (t_ - start_t_); }

double StepCourse::touch(std::size_t count) const {
  double first = INFINITY;
  for (std::size_t i = 0; i < count; ++i) {
    if (std::abs(start_g_[i]) <= smallest || changed(i)) continue;  // its mode begins here, or ends
    const bool approaches = before_[i] ? start_gdot_[i] < 0 : start_gdot_[i] > 0;
    if (!approaches) continue;
    const Cubic course = cubic(i);
    if (!course.has_extremum()) continue;
    const double s = course.extremum();
    const double nearest = before_[i] ? course.value(s) : -course.value(s);
    const double approach = std::max(std::abs(start_g_[i]), std::abs(g_[i])) - nearest;
    if (nearest > cubic_error_fraction * approach || s < min_end_distance || s > 1 - min_end_distance) continue;
    first = std::min(first, start_t_ + s * (t_ - start_t_));
  }
  return first;
}

void StepCourse::serialize(Archive& archive) {
  archive.serialize(start_t_, start_g_, start_gdot_);
  for (std::size_t i = 0; i < size(); ++i) archive.serialize(before_[i]);
}

}  // namespace gelenk
