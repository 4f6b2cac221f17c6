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
// Of the kinetic energy, that projections may remove in all: this fraction of the tolerance, and never less than
// roundings of some hundred steps. Where deviations are beyond rounding, what reaches a singular configuration loses
// 1e-10 of a tolerance. Mechanisms of two loops that miss it by 1e-7 of their length, whose exponents differ from those
// above, lose all their energy if they are not recognized by this.
constexpr double largest_removed = 1e-5;
constexpr double least_removed = 1e-13;
// Where deviations may be rounding, slider-cranks that reach a singular configuration lose up to 7e-9.
constexpr double evident_removed = 1e-7;

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

void SingularApproach::compare(double fraction, double deviation, double rounding) {
  contradicts_ = deviation > clear_of_rounding * rounding;
  if (decided_ || fraction > (compared_ == 0 ? largest_first : largest_next * fractions_[compared_ - 1])) return;
  fractions_[compared_] = fraction;
  deviations_[compared_] = deviation;
  decided_ = ++compared_ == needed || !contradicts_;
  misses_ = compared_ == needed && contradicts_;
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
