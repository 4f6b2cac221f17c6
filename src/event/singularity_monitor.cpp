// SPDX-License-Identifier: BSD-3-Clause
#include "event/singularity_monitor.h"

#include <algorithm>

namespace gelenk {
namespace {

// Relative to the largest ratio observed.
constexpr double recording_fraction = 0.5;  // samples below it are recorded
constexpr double near_fraction = 0.2;       // an approach with larger ratios is ignored
constexpr double zero_fraction = 0.02;      // counts as zero: accuracy of the parabola through samples on both sides

}  // namespace

void SingularityMonitor::observe(double t, double ratio) {
  best_pivot_ratio_ = std::max(best_pivot_ratio_, ratio);
  const bool low = ratio < near_fraction * best_pivot_ratio_;
  if (!low) regular_from_ = std::min(regular_from_, t);
  if (!(ratio <= recording_fraction * best_pivot_ratio_)) return;
  if (low && armed_) near_ = true;
  samples_[next_] = {t, ratio * ratio};
  next_ = (next_ + 1) % static_cast<int>(samples_.size());
  size_ = std::min(size_ + 1, static_cast<int>(samples_.size()));
}

SingularityMonitor::Minimum SingularityMonitor::find_minimum(double& time) const {
  const auto end = samples_.begin() + size_;
  const auto lowest = std::min_element(samples_.begin(), end, [](auto& a, auto& b) { return a.square < b.square; });
  const Sample* before = nullptr;
  const Sample* after = nullptr;
  for (auto s = samples_.begin(); s != end; ++s) {
    if (s->t < lowest->t && (before == nullptr || s->t > before->t)) before = &*s;
    if (s->t > lowest->t && (after == nullptr || s->t < after->t)) after = &*s;
  }
  if (after == nullptr) return Minimum::not_passed;
  const double zero = zero_fraction * zero_fraction * best_pivot_ratio_ * best_pivot_ratio_;
  time = lowest->t;
  if (before == nullptr) return Minimum::not_zero;  // moving away from the start of the run or from the last crossing
  if (lowest->square <= zero) return Minimum::zero;
  const double fall = (lowest->square - before->square) / (lowest->t - before->t);
  const double rise = (after->square - lowest->square) / (after->t - lowest->t);
  const double curvature = (rise - fall) / (after->t - before->t);
  const double gradient = fall + curvature * (lowest->t - before->t);  // at the lowest sample
  if (!(curvature > 0) || lowest->square > zero + gradient * gradient / (4 * curvature)) return Minimum::not_zero;
  time = lowest->t - gradient / (2 * curvature);
  return Minimum::zero;
}

void SingularityMonitor::accepted(double t) {
  if (regular_from_ <= t) armed_ = true;
  if (!near_) {
    size_ = next_ = 0;
    return;
  }
  double time = 0;
  const Minimum found = find_minimum(time);
  if (found == Minimum::not_passed) return;
  // Evaluations are ahead of accepted steps, and their step may be rejected.
  if (found == Minimum::zero) {
    if (time > t) return;
    ++count_;
    last_ = time;
    armed_ = false;
    regular_from_ = INFINITY;
  }
  near_ = false;
  size_ = next_ = 0;
}

void SingularityMonitor::serialize(Archive& archive) {
  const int capacity = static_cast<int>(samples_.size());
  archive.serialize_in_range(size_, 0, capacity);
  archive.serialize_in_range(next_, 0, capacity - 1);
  for (int i = 0; i < size_; ++i) archive.serialize(samples_[i].t, samples_[i].square);
  archive.serialize(best_pivot_ratio_, near_, regular_from_, armed_, count_, last_);
}

void SingularityMonitor::restart(double t) {
  if (last_ > t) --count_;
  last_ = std::min(last_, t);
  armed_ = true;
  regular_from_ = INFINITY;
  near_ = false;
  size_ = next_ = 0;
}

}  // namespace gelenk
