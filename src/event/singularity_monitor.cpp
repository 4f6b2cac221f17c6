// SPDX-License-Identifier: BSD-3-Clause
#include "event/singularity_monitor.h"

#include <algorithm>

namespace gelenk {
namespace {

// As shares of the soundest ratio seen.
constexpr double kept_share = 0.5;      // below it samples are kept
constexpr double near_fraction = 0.2;   // an approach that stays above is none
constexpr double zero_fraction = 0.02;  // what counts as zero: the parabola through steps astride is good to about this

}  // namespace

void SingularityMonitor::observe(double t, double ratio) {
  best_pivot_ratio_ = std::max(best_pivot_ratio_, ratio);
  const bool low = ratio < near_fraction * best_pivot_ratio_;
  if (!low) sound_from_ = std::min(sound_from_, t);
  if (!(ratio <= kept_share * best_pivot_ratio_)) return;
  if (low && armed_) near_ = true;
  samples_[next_] = {t, ratio * ratio};
  next_ = (next_ + 1) % static_cast<int>(samples_.size());
  size_ = std::min(size_ + 1, static_cast<int>(samples_.size()));
}

SingularityMonitor::Foot SingularityMonitor::foot(double& time) const {
  const auto end = samples_.begin() + size_;
  const auto lowest = std::min_element(samples_.begin(), end, [](auto& a, auto& b) { return a.square < b.square; });
  const Sample* before = nullptr;
  const Sample* after = nullptr;
  for (auto s = samples_.begin(); s != end; ++s) {
    if (s->t < lowest->t && (before == nullptr || s->t > before->t)) before = &*s;
    if (s->t > lowest->t && (after == nullptr || s->t < after->t)) after = &*s;
  }
  if (after == nullptr) return Foot::not_passed;
  const double zero = zero_fraction * zero_fraction * best_pivot_ratio_ * best_pivot_ratio_;
  time = lowest->t;
  if (before == nullptr) return Foot::not_zero;  // away from where the run began, or from the last one
  if (lowest->square <= zero) return Foot::zero;
  const double fall = (lowest->square - before->square) / (lowest->t - before->t);
  const double rise = (after->square - lowest->square) / (after->t - lowest->t);
  const double curvature = (rise - fall) / (after->t - before->t);
  const double slope = fall + curvature * (lowest->t - before->t);  // at the lowest sample
  if (!(curvature > 0) || lowest->square > zero + slope * slope / (4 * curvature)) return Foot::not_zero;
  time = lowest->t - slope / (2 * curvature);
  return Foot::zero;
}

void SingularityMonitor::accepted(double t) {
  if (sound_from_ <= t) armed_ = true;
  if (!near_) {
    size_ = next_ = 0;
    return;
  }
  double time = 0;
  const Foot found = foot(time);
  if (found == Foot::not_passed) return;
  // Evaluations run ahead of accepted steps; what they saw may be taken back.
  if (found == Foot::zero) {
    if (time > t) return;
    ++count_;
    last_ = time;
    armed_ = false;
    sound_from_ = INFINITY;
  }
  near_ = false;
  size_ = next_ = 0;
}

void SingularityMonitor::serialize(Archive& archive) {
  const int most = static_cast<int>(samples_.size());
  archive.serialize_in_range(size_, 0, most);
  archive.serialize_in_range(next_, 0, most - 1);
  for (int i = 0; i < size_; ++i) archive.serialize(samples_[i].t, samples_[i].square);
  archive.serialize(best_pivot_ratio_, near_, sound_from_, armed_, count_, last_);
}

void SingularityMonitor::restart(double t) {
  if (last_ > t) --count_;
  last_ = std::min(last_, t);
  armed_ = true;
  sound_from_ = INFINITY;
  near_ = false;
  size_ = next_ = 0;
}

}  // namespace gelenk
