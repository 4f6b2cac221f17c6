// SPDX-License-Identifier: BSD-3-Clause
// Timing of a call in all programs of the measurements: the smallest mean of several blocks, each long compared with
// the resolution of the clock and short compared with interruptions.
#pragma once

#include <algorithm>

#include "ref_kernel.h"

// Returns the time of one call [s]. budget [s]: approximate measuring time; at least one call is made.
template <class Call>
double least_time(Call&& call, double budget = 0.03) {
  const auto mean = [&](long calls) {
    const double begin = cpu_seconds();
    for (long i = 0; i < calls; ++i) call();
    return (cpu_seconds() - begin) / static_cast<double>(calls);
  };
  double least = std::max(mean(1), 1e-9);
  double spent = least;
  // The caches are cold in the first call: a warm block determines the length of a block.
  if (spent < budget) least = std::min(least, mean(std::clamp(static_cast<long>(1e-4 / least), 1L, 1000L)));
  const long calls = std::clamp(static_cast<long>(budget / 15 / least), 1L, 1000000L);
  for (int i = 0; i < 15 && spent < budget; ++i) {
    const double found = mean(calls);
    spent += found * static_cast<double>(calls);
    least = std::min(least, found);
  }
  return least;
}
