// SPDX-License-Identifier: BSD-3-Clause
// Holds what events do to velocities without impulses against what explains it: what comes to rest is at rest within
// rounding, or rebounds too low to matter, and nothing else changes. It knows nothing of how coordinates are stopped.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace gelenk {

// The largest change of a velocity that is not refused, relative to the largest velocity or 1: far more than rounding,
// tolerances of integrators, and what solvers leave after impacts.
inline constexpr double audited_stop = 1e-4;

// How much further the velocities change than that, from before to after; more than 1 is refused. rebound: the speed of
// the fastest rebound that is too low to matter.
inline double excess_of_stop(std::span<const double> before, std::span<const double> after, double rebound) {
  double fastest = 1, change = 0;
  for (std::size_t k = 0; k < before.size(); ++k) {
    fastest = std::max(fastest, std::abs(before[k]));
    change = std::max(change, std::abs(after[k] - before[k]));
  }
  return change / std::max(audited_stop * fastest, rebound);
}

}  // namespace gelenk
