// SPDX-License-Identifier: BSD-3-Clause
// Weights of the constraint equations along directions of weak pivots. ratio: of a pivot to the largest; threshold: the
// ratio at which an equation and what replaces it count alike; 0: no pivot is weak.
#pragma once

#include <cmath>

namespace gelenk {

// Of a correction.
inline double damping_weight(double ratio, double threshold) {
  if (threshold == 0) return 1;
  return ratio * ratio / (ratio * ratio + threshold * threshold);
}

// Of an equation beside an extrapolation. The errors of equations grow with ratio^-3, and are those of the
// extrapolation at the threshold: these weights give the sum of both the least variance.
inline double equation_weight(double ratio, double threshold) {
  if (threshold == 0) return 1;
  const double sixth = std::pow(ratio / threshold, 6);
  return std::isfinite(sixth) ? sixth / (sixth + 1) : 1;
}

}  // namespace gelenk
