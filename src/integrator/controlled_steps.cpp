// SPDX-License-Identifier: BSD-3-Clause
#include "integrator/controlled_steps.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gelenk {
namespace {

// accuracy_of_steps(): 1e-4 for the default tolerance of 1e-6. Below the finest, impacts would cost too many steps;
// above the coarsest, steps would not resolve the motion.
constexpr double accuracy_factor = 0.1;
constexpr double finest_accuracy = 1e-6;
constexpr double coarsest_accuracy = 1e-3;
// Residual velocities of the impulses, by how far they move something in a second, in units of the accuracy of a pair.
constexpr double drift_fraction = 0.01;
// Except for stability, pairs are not shorter than solver.step halved this many times, nor, down to the second number,
// so short that a communication step would need more pairs than this, since its cost is bounded
// (solver.max_evaluations): what remains of errors is estimated.
constexpr int most_halvings = 13;
constexpr int ordinary_halvings = 6;
constexpr double most_pairs = 2048;
// The second run makes the longest steps, of up to this part of those at which they become unstable, 2 / frequency:
// steps that change are stable in a smaller range.
constexpr double stable_fraction = 0.4;
constexpr double stability_limit_of_steps = 2;
constexpr int pairs_between_checks = 50;
// Pairs with so small a part of the error permitted that twice the length would do, of order 2; number of them after
// which pairs become longer. After a step that failed, which is costly, so many more.
constexpr double calm_fraction = 1.0 / 16;
constexpr int calm_pairs = 4;
constexpr int calm_after_failure = 64;
// Where velocities jump within a pair, so do the accelerations of bodies that turn, and the error of the velocities is
// of the order of the step. It counts by what it adds to positions within this time [s], in which the estimate for the
// run may grow by ten times the accuracy of a pair.
constexpr double time_after_jump = 0.1;
// The estimate for the run: time between two reviews and its share [steps of solver.step]; factors of the share beyond
// which the steps are halved, below which they are doubled; halvings for this reason; and the part of all shares so far
// beyond which the error cannot be kept.
constexpr double steps_between_reviews = 5;
constexpr double steps_per_share = 100;
constexpr double share_of_accuracy = 10;
constexpr double most_growth = 2;
constexpr double least_growth = 1.0 / 8;
constexpr int most_halvings_for_share = 6;
constexpr double beyond_recovery = 10;
// Part of the estimate for the run than which no pair need be more accurate: where the motion is chaotic, accuracy is
// of no use.
constexpr double part_of_estimate = 0.01;
// Rounding of times, relative to steps.
constexpr double rounding = 1e-9;

}  // namespace

double accuracy_of_steps(double tolerance) {
  return std::clamp(accuracy_factor * std::sqrt(tolerance), finest_accuracy, coarsest_accuracy);
}

ControlledSteps::ControlledSteps(Equations& system, const IntegratorOptions& options, bool always)
    : system_(system),
      impulses_(*system.impulses()),
      step_(options.step),
      accuracy_(accuracy_of_steps(options.tolerance)),
      always_(always),
      nq_(static_cast<std::size_t>(system.coordinates())),
      nv_(static_cast<std::size_t>(system.velocities())),
      y_(static_cast<std::size_t>(system.size())),
      start_(y_),
      middle_(y_),
      second_(y_),
      last_(nv_),
      f1_(nv_),
      f2_(nv_) {
  impulses_.use({.relative = options.cone_tolerance, .absolute = drift_fraction * accuracy_});
}

void ControlledSteps::restart(double t, const double* y) {
  t_ = t;
  std::copy_n(y, y_.size(), y_.begin());
  memory_.is_second_apart = false;
  memory_.until_check = 0;
  memory_.last_step = 0;
  if (started_) return;  // a state that is restored has its forces
  started_ = true;
  if (always_) impulses_.start(t, step_, y);
}

void ControlledSteps::inputs_changed() {
  memory_.until_check = 0;
  memory_.last_step = 0;
}

void ControlledSteps::begin(SchemeChange::Cause cause) {
  if (memory_.is_stepping) return;
  memory_.is_stepping = true;
  if (memory_.parts++ == 0) {
    memory_.first = t_;
    memory_.cause = cause;
  }
  memory_.since = t_;
  memory_.halvings = memory_.halvings_for_share = memory_.calm = 0;
  memory_.reviewed = t_;
  memory_.error_reviewed = memory_.error;
  memory_.rate_reviewed = 0;
  impulses_.report({.time = t_, .cause = cause});
}

void ControlledSteps::end() {
  if (!memory_.is_stepping) return;
  memory_.is_stepping = false;
  memory_.elapsed += t_ - memory_.since;
  memory_.until = t_;
  impulses_.report({.time = t_, .since = memory_.since, .error = memory_.error});
}

Integrator::SteppedTime ControlledSteps::stepped_time() const {
  const Memory& of = memory_;
  return {.parts = of.parts,
          .cause = of.cause,
          .from = of.first,
          .to = of.is_stepping ? t_ : of.until,
          .time = of.elapsed + (of.is_stepping ? t_ - of.since : 0),
          .error = of.error};
}

double ControlledSteps::advance(double end, double* y) {
  return advance_some(end, y, std::numeric_limits<long>::max());
}

double ControlledSteps::advance_some(double end, double* y, long max_steps) {
  if (shortest_ == 0)
    shortest_ =
        std::clamp((end - t_) / most_pairs, std::ldexp(step_, -most_halvings), std::ldexp(step_, -ordinary_halvings));
  system_.polish(false);
  if (always_) begin(SchemeChange::Cause::not_located);
  if (!memory_.is_second_apart) begin_second();
  for (long made = 0; t_ < end && made < max_steps; made += 2) {
    make_pair(end);
    if (system_.budget_exhausted()) break;
  }
  std::ranges::copy(y_, y);
  return t_;
}

double ControlledSteps::accuracy() const { return std::max(accuracy_, part_of_estimate * memory_.error); }

// Of the next pair, such that equal ones lead to `end`.
double ControlledSteps::length_towards(double end) {
  if (memory_.until_check-- <= 0) {
    memory_.frequency = impulses_.highest_frequency(t_, y_.data());
    memory_.until_check = pairs_between_checks;
  }
  double h = std::ldexp(step_, -std::max(memory_.halvings, memory_.halvings_for_share));
  const double longest = stable_fraction * stability_limit_of_steps / memory_.frequency;  // infinite without vibrations
  while (h > longest) h /= 2;
  const double span = end - t_;
  return span / std::max(1.0, std::ceil(span / h - rounding));
}

void ControlledSteps::make_pair(double end) {
  const double start = t_;
  double h = length_towards(end);
  double error = 0;
  start_ = y_;
  impulses_.keep();
  for (bool is_again = false;; is_again = true) {
    const bool made = try_pair(start, h);
    error = made ? local_error(h / 2) : 0;
    const bool is_shortest = h <= (1 + rounding) * shortest_;  // equal parts of the time that is left are rounded
    if (made && (error <= accuracy() || is_shortest)) break;
    if (!made && is_shortest)
      refuse(system_, start, start_.data(), "velocities or forces are not finite, or too large for numbers");
    ++rejected_;
    y_ = start_;
    impulses_.return_to_kept();
    impulses_.keep();
    shorten(h, made ? error / accuracy() : 1, is_again);
    if (!made) memory_.calm = -calm_after_failure;
    h = length_towards(end);
  }
  t_ = end - start - h <= rounding * h ? end : start + h;
  system_.accepted(t_, y_.data());
  steps_ += 2;
  changes_ += changed_ ? 1 : 0;
  last_.swap(f2_);
  memory_.last_step = h / 2;
  lengthen(error);
  step_second(start, h);
  if (t_ - memory_.reviewed >= (1 - rounding) * steps_between_reviews * step_) review();
}

// Makes two steps of the first run; returns false if one fails.
bool ControlledSteps::try_pair(double t, double h) {
  const long changes = impulses_.activity().changes;
  const double s = h / 2;
  if (!impulses_.step(t, s, y_.data()) || !system_.project(t + s, y_.data())) return false;
  middle_ = y_;
  std::copy_n(impulses_.smooth_accelerations(), nv_, f1_.begin());
  if (!impulses_.step(t + s, s, y_.data()) || !system_.project(t + h, y_.data())) return false;
  std::copy_n(impulses_.smooth_accelerations(), nv_, f2_.begin());
  changed_ = impulses_.activity().changes != changes;
  return true;
}

// Of the present pair of steps of length s.
double ControlledSteps::local_error(double s) const {
  double of_positions = 0, of_velocities = 0;
  const double before = (memory_.last_step + s) / 2;  // between the middles of steps
  for (std::size_t k = 0; k < nv_; ++k) {
    const double v2 = y_[nq_ + k];
    of_positions = std::max(of_positions, std::abs(v2 - 2 * middle_[nq_ + k] + start_[nq_ + k]));
    if (memory_.last_step == 0) continue;
    const double second_difference = ((f2_[k] - f1_[k]) / s - (f1_[k] - last_[k]) / before) / ((s + before) / 2);
    of_velocities = std::max(of_velocities, std::abs(second_difference) / std::max(1.0, std::abs(v2)));
  }
  return std::max(s / 6 * of_positions, s * s * s / 12 * of_velocities * (changed_ ? time_after_jump : 1));
}

// After a pair of length h whose error exceeds the accuracy by this factor. It is in proportion to the length where
// velocities jump, and to its third power elsewhere.
void ControlledSteps::shorten(double h, double excess, bool is_again) {
  const double by = std::log2(excess) / (changed_ || is_again ? 1 : 3);
  const double most = std::ceil(std::log2(step_ / shortest_) - rounding);
  const double present = std::ceil(std::log2(step_ / h) - rounding);
  memory_.halvings = static_cast<int>(std::min(present + std::max(1.0, std::ceil(by)), most));
  memory_.calm = 0;
}

void ControlledSteps::lengthen(double error) {
  memory_.calm = error < calm_fraction * accuracy() ? memory_.calm + 1 : std::min(memory_.calm, 0);
  if (memory_.calm < calm_pairs) return;
  memory_.calm = 0;
  memory_.halvings = std::max(0, memory_.halvings - 1);
}

// Compares the growth of the estimate for the run with its share of the time since the last review.
void ControlledSteps::review() {
  const double growth = memory_.error - memory_.error_reviewed;
  const double share = share_of_accuracy * accuracy_ / (steps_per_share * step_);  // per second
  const double permitted = share * (t_ - memory_.reviewed);
  const double stepped = memory_.elapsed + t_ - memory_.since;
  const bool is_lost = memory_.error > beyond_recovery * share * (stepped + steps_per_share * step_);
  int& halvings = memory_.halvings_for_share;
  // What follows from velocities in which the runs differed already, as after an impact: shorter steps do not reduce
  // it.
  const double carried = memory_.rate_reviewed * (t_ - memory_.reviewed);
  if (is_lost || growth < least_growth * permitted) {
    halvings = std::max(0, halvings - 1);
  } else if (growth - carried > most_growth * permitted) {
    halvings = std::min(halvings + 1, most_halvings_for_share);
  }
  memory_.reviewed = t_;
  memory_.error_reviewed = memory_.error;
  memory_.rate_reviewed = 0;
  for (std::size_t k = nq_; k < nq_ + nv_; ++k)
    memory_.rate_reviewed = std::max(memory_.rate_reviewed, std::abs(y_[k] - second_[k]));
}

// From where the first run is.
void ControlledSteps::begin_second() {
  second_ = y_;
  impulses_.copy_to_second();
  memory_.is_second_apart = true;
  memory_.error_before = memory_.error;
}

void ControlledSteps::step_second(double t, double h) {
  impulses_.exchange_with_second();
  const bool made = impulses_.step(t, h, second_.data()) && system_.project(t + h, second_.data());
  impulses_.exchange_with_second();
  if (!made) return begin_second();
  double distance = 0;
  for (std::size_t k = 0; k < nq_; ++k) distance = std::max(distance, std::abs(y_[k] - second_[k]));
  for (std::size_t k = nq_ + nv_; k < y_.size(); ++k) distance = std::max(distance, std::abs(y_[k] - second_[k]));
  memory_.error = std::max(memory_.error, memory_.error_before + distance);
}

void ControlledSteps::serialize(Archive& archive) {
  Integrator::serialize(archive);
  Memory& of = memory_;
  archive.serialize_in_range(of.halvings, 0, most_halvings);
  archive.serialize_in_range(of.halvings_for_share, 0, most_halvings_for_share);
  archive.serialize_in_range(of.calm, -calm_after_failure, calm_pairs);
  archive.serialize(of.frequency, of.last_step, of.is_second_apart, of.error, of.error_before, of.reviewed);
  archive.serialize(of.error_reviewed, of.rate_reviewed);
  archive.serialize_in_range(of.until_check, -1, pairs_between_checks);
  archive.serialize(of.first, of.since, of.elapsed, of.until, of.parts, of.is_stepping);
  int cause = static_cast<int>(of.cause);
  archive.serialize_in_range(cause, 0, static_cast<int>(SchemeChange::Cause::overlap));
  of.cause = static_cast<SchemeChange::Cause>(cause);
  archive.serialize(second_, last_, shortest_);
}

}  // namespace gelenk
