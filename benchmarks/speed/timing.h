// SPDX-License-Identifier: BSD-3-Clause
// How every program of the measurements times a call: the least mean of some blocks, each long against the clock's
// grain and short against whatever interrupts.
#pragma once

#include <algorithm>

#include "ref_kernel.h"

// s of one call. budget [s]: what measuring may take, about; at least one call is made.
template <class Call>
double least_time(Call&& call, double budget = 0.03) {
  const auto mean = [&](long calls) {
    const double begin = cpu_seconds();
    for (long i = 0; i < calls; ++i) call();
    return (cpu_seconds() - begin) / static_cast<double>(calls);
  };
  double least = std::max(mean(1), 1e-9);
  double spent = least;
  // The first call finds cold caches: the length of a block goes by one warm block.
  if (spent < budget) least = std::min(least, mean(std::clamp(static_cast<long>(1e-4 / least), 1L, 1000L)));
  const long calls = std::clamp(static_cast<long>(budget / 15 / least), 1L, 1000000L);
  for (int i = 0; i < 15 && spent < budget; ++i) {
    const double found = mean(calls);
    spent += found * static_cast<double>(calls);
    least = std::min(least, found);
  }
  return least;
}
