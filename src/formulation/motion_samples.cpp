// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/motion_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gelenk {
namespace {

// Largest ratio of the mean rates of two consecutive steps of a smooth motion. A uniformly accelerated motion that
// starts from rest at a communication point has the ratios 3, 5/3, 7/5, ...; a jump within twice the last
// displacement is taken for motion.
constexpr double max_rate_ratio = 3;
// Smallest step relative to t whose length is known to a millionth, despite the rounding of both times.
constexpr double min_relative_step = 1e6 * std::numeric_limits<double>::epsilon();
// Jumps below this, relative to the value and to 1 [m, rad], are not reported: they change nothing visibly.
constexpr double min_reported_jump = 1e-6;
constexpr int max_count = 3;

bool are_similar(double a, double b) {
  return a * b > 0 && std::abs(a) <= max_rate_ratio * std::abs(b) && std::abs(b) <= max_rate_ratio * std::abs(a);
}

double minmod(double a, double b) {
  if (!(a * b > 0)) return 0;
  return std::abs(a) < std::abs(b) ? a : b;
}

}  // namespace

MotionSamples::Derivatives MotionSamples::add(double t, double value) {
  jump_ = {};
  since_start_ = 0;
  has_present_ = true;
  present_ = {t, value, 0, 0};
  if (count_ == 0) return derivatives_ = {};
  const double h = t - last_.time;
  if (!(h > min_relative_step * std::abs(t))) {
    has_present_ = false;
    return {derivatives_.first + derivatives_.second * h, derivatives_.second};
  }
  present_.rate = (value - last_.value) / h;
  present_.span = h;
  if (count_ == 1) {
    since_start_ = h;
    return derivatives_ = {};
  }
  return derivatives_ = rates_to_present();
}

MotionSamples::Derivatives MotionSamples::rates_to_present() {
  find_jump();
  const double rate = present_.rate;
  if (!are_similar(rate, last_.rate)) return {minmod(rate, last_.rate), 0};
  if (count_ == 2 && last_.span > 0) since_start_ = present_.span + last_.span;
  const double curvature = (rate - last_.rate) / (present_.span + last_.span);
  const Derivatives out{rate + present_.span * curvature, 2 * curvature};
  return std::isfinite(out.first) && std::isfinite(out.second) ? out : Derivatives{};
}

// The rate of the step before differs from those of both its neighbors.
void MotionSamples::find_jump() {
  if (warned_ || last_.span == 0) return;
  if (count_ == 2 && present_.rate != 0) return;  // perhaps a motion that has begun at the start
  const double around = std::max(std::abs(present_.rate), count_ == 2 ? 0 : std::abs(rate_before_));
  if (!(std::abs(last_.rate) > max_rate_ratio * around)) return;
  const double size = (last_.rate - minmod(present_.rate, rate_before_)) * last_.span;
  if (is_visible(size, last_.value)) jump_ = {last_.time, size};
}

bool MotionSamples::is_visible(double size, double value) {
  return std::abs(size) > min_reported_jump * (1 + std::abs(value));
}

void MotionSamples::add(double t, double value, double rate) {
  jump_ = {};
  since_start_ = 0;
  has_present_ = true;
  present_ = {t, value, rate, 0};
  count_ = std::max(count_, 1);
  derivatives_ = {rate, 0};
}

void MotionSamples::commit() {
  if (!has_present_) {
    jump_ = {};  // reported after an earlier part of the step
    return;
  }
  has_present_ = false;
  rate_before_ = last_.rate;
  last_ = present_;
  count_ = std::min(count_ + 1, max_count);
  warned_ = warned_ || jump_.size != 0;
}

void MotionSamples::serialize(Archive& archive) {
  for (Sample* s : {&last_, &present_}) archive.serialize(s->time, s->value, s->rate, s->span);
  archive.serialize(rate_before_, derivatives_.first, derivatives_.second, since_start_);
  archive.serialize_in_range(count_, 0, max_count);
  archive.serialize(has_present_, warned_, jump_.time, jump_.size);
}

}  // namespace gelenk
