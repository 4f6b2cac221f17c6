// SPDX-License-Identifier: BSD-3-Clause
// Finds the fixed values that contradict each other if they cannot all be satisfied.
#pragma once

#include <vector>

#include "assembly/assembly.h"

namespace gelenk {

// Conflicting fixed coordinates; q: the position with the smallest closure error. They are found by omitting one after
// the other and searching again, which costs as many searches; empty also if there are too many of them for that.
Conflict conflicting_positions(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree,
                               const InitialGuess& cuts, const std::vector<double>& q);

// Conflicting fixed velocities at q. tolerance: of the rates [m/s, rad/s]; singular: relative to the largest pivot,
// below which one is zero.
Conflict conflicting_velocities(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree,
                                const InitialGuess& cuts, const std::vector<double>& q, double tolerance,
                                double singular);

}  // namespace gelenk
