// SPDX-License-Identifier: BSD-3-Clause
// Counts singular positions on the way: where a loop's rows lose rank for a moment (a change point, a dead centre) and
// the mechanism might go on by another branch.
#pragma once

#include <array>
#include <cmath>

#include "util/archive.h"

namespace gelenk {

class SingularityMonitor {
 public:
  // An evaluation at t [s], or an accepted state, has this smallest pivot ratio of the rows (row_factor.h).
  void observe(double t, double ratio);
  // A step to t [s] has been accepted.
  void accepted(double t);
  // The run begins anew at t [s]: back at a former time, or at the first.
  void restart(double t);

  void serialize(Archive& archive);

  long count() const { return count_; }
  double last() const { return last_; }  // s: about when the last one was passed

 private:
  struct Sample {
    double t, square;  // s; of the ratio
  };

  double best_pivot_ratio_ = 0;  // ratio seen
  // The latest below a share of it, in a ring. The ratio falls and rises as |t - t0|, its square as a parabola.
  std::array<Sample, 64> samples_{};
  int size_ = 0;
  int next_ = 0;
  bool near_ = false;             // one of them is low enough for a passage
  double sound_from_ = INFINITY;  // s: of the first evaluation away from the last passage; counts once accepted
  bool armed_ = true;             // it has been accepted
  long count_ = 0;
  double last_ = -INFINITY;

  // Where the samples rise on both sides of the lowest: whether the square comes down to zero there, and when.
  enum class Foot { not_passed, zero, not_zero };
  Foot foot(double& time) const;
};

}  // namespace gelenk
