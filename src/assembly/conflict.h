// SPDX-License-Identifier: BSD-3-Clause
// Which of the fixed values contradict each other, when they cannot all be met.
#pragma once

#include <vector>

#include "assembly/assembly.h"

namespace gelenk {

// Of coordinates. q: where the gap was smallest. Found by leaving one after the other out and searching again, so it
// costs as many searches; empty also where there are too many of them for that.
Conflict conflicting_positions(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree,
                               const InitialGuess& cuts, const std::vector<double>& q);

// Of speeds, at q. tolerance: of the rates [m/s, rad/s]; singular: of the largest pivot, below which one is zero.
Conflict conflicting_speeds(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree,
                            const InitialGuess& cuts, const std::vector<double>& q, double tolerance, double singular);

}  // namespace gelenk
