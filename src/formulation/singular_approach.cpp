// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/singular_approach.h"

#include <algorithm>
#include <cmath>

namespace gelenk {
namespace {

// Pivot fractions of the first state that is compared. Beyond, extrapolations over long steps have large errors of
// their own.
constexpr double largest_first = 0.03;
constexpr double largest_next = 0.5;  // of the one before
// Those at which steps aim.
constexpr double first = 0.02;
constexpr double next = 0.4;
// Exponents of the deviation. Those of four-bars that miss the flat position by 1e-9 to 1e-5 of their length are 2.8 to
// 3.2; of 2700 pairs of states on the way to or from a singular configuration of parallelograms, at tolerances from
// 1e-3 to 1e-10, five exceed the least without being rounding, never two in a row.
constexpr double least_exponent = 2.3;
// Of rounding: smaller deviations are no evidence of a miss. A run that starts shortly before a singular configuration
// has some 3e3, a four-bar that misses by 1e-9 of its length 3e6. What misses by less than some 1e-10 of it is taken
// to reach the singular configuration.
constexpr double clear_of_rounding = 1e5;
// Mechanisms of two loops that miss a singular configuration by 1e-7 of their length, whose exponents differ from those
// above, would lose all their energy. Of the kinetic energy, projections may remove this fraction of the tolerance in
// all, and never less than roundings of some hundred steps, if deviations contradict the extrapolation on the way in:
// beyond rounding, and by more than its accelerations. Near a singular configuration that is reached, slider-cranks
// lose up to 2e-6 of their energy by errors of the state, with deviations up to 1.03 times the accelerations.
constexpr double least_contradiction = 1.5;
constexpr double largest_removed = 1e-5;
constexpr double least_removed = 1e-13;
// Beyond this without any condition.
constexpr double evident_removed = 1e-4;

}  // namespace

void SingularApproach::pass(double t, double fraction) {
  if (known_ && t > time_) rate_ = (fraction - fraction_) / (t - time_);
  known_ = true;
  time_ = t;
  fraction_ = fraction;
}

double SingularApproach::end_of_step(double t) const {
  const double wanted = compared_ == 0 ? first : next * fractions_[compared_ - 1];
  if (!known_ || decided_ || !(rate_ < 0) || !(fraction_ > wanted)) return INFINITY;
  return t + (fraction_ - wanted) / -rate_;
}

void SingularApproach::compare(double fraction, double deviation, double size, double rounding) {
  const bool is_clear = deviation > clear_of_rounding * rounding;
  contradicts_ = rate_ < 0 && is_clear && deviation > least_contradiction * size;
  if (decided_ || fraction > (compared_ == 0 ? largest_first : largest_next * fractions_[compared_ - 1])) return;
  fractions_[compared_] = fraction;
  deviations_[compared_] = deviation;
  decided_ = ++compared_ == needed || !is_clear;
  misses_ = compared_ == needed && is_clear;
  if (!misses_) return;
  for (int i = 1; i < needed; ++i) {
    const double exponent = std::log(deviations_[i] / deviations_[i - 1]) / std::log(fractions_[i - 1] / fractions_[i]);
    misses_ = misses_ && exponent > least_exponent;
  }
}

void SingularApproach::remove_energy(double before, double after, double tolerance) {
  largest_ = std::max(largest_, before);
  removed_ += std::max(0.0, before - after);
  const double allowed = contradicts_ ? std::max(largest_removed * tolerance, least_removed) : evident_removed;
  if (removed_ > allowed * largest_) decided_ = misses_ = true;
}

void SingularApproach::serialize(Archive& archive) {
  archive.serialize(time_, fraction_, rate_);
  archive.serialize_in_range(compared_, 0, needed);
  for (int i = 0; i < needed; ++i) archive.serialize(fractions_[i], deviations_[i]);
  archive.serialize(known_, decided_, misses_, contradicts_, removed_, largest_);
}

}  // namespace gelenk
