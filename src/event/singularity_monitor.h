// SPDX-License-Identifier: BSD-3-Clause
// Counts the singular configurations crossed, at which the constraint Jacobian of a loop momentarily loses rank (a
// change point, a dead center) and the mechanism could continue on another branch.
#pragma once

#include <array>
#include <cmath>

#include "util/archive.h"

namespace gelenk {

class SingularityMonitor {
 public:
  // Records the smallest pivot ratio of the constraint Jacobian (row_factor.h) at t [s], in an evaluation or an
  // accepted state.
  void observe(double t, double ratio);
  // Call when a step to t [s] has been accepted.
  void accepted(double t);
  // Call when the run restarts at t [s], at an earlier time or at its beginning.
  void restart(double t);

  void serialize(Archive& archive);

  // Whether an approach is followed, for which all evaluations have to be recorded.
  bool is_followed() const { return near_ || !armed_; }
  // The largest ratio is at least this one.
  void expect(double ratio) { best_pivot_ratio_ = std::max(best_pivot_ratio_, ratio); }

  long count() const { return count_; }
  double last() const { return last_; }  // s: approximate time of the last crossing

 private:
  struct Sample {
    double t, square;  // s; square of the ratio
  };

  double best_pivot_ratio_ = 0;  // largest ratio observed
  // A ring buffer of the latest samples below a fraction of it. Near a crossing at t0 the ratio is proportional to |t -
  // t0|, so its square is a parabola.
  std::array<Sample, 64> samples_{};
  int size_ = 0;
  int next_ = 0;
  bool near_ = false;               // one of the samples is low enough for a crossing
  double regular_from_ = INFINITY;  // s: first regular evaluation after the last crossing
  bool armed_ = true;               // a step beyond it has been accepted
  long count_ = 0;
  double last_ = -HUGE_VAL;

  // Looks for a minimum with larger samples on both sides: whether the square reaches zero there, and its time.
  enum class Minimum { not_passed, zero, not_zero };
  Minimum find_minimum(double& time) const;
};

}  // namespace gelenk
