// SPDX-License-Identifier: BSD-3-Clause
// Starts in or beside a singular configuration (a change point, a dead centre), where branches of motion meet.
#pragma once

#include "analysis/mobility.h"
#include "assembly/assembly.h"

namespace gelenk {

struct SingularStart {
  double share = 1;       // smallest pivot of the constraint equations over the soundest one known; 0: rank is lost
  int row = -1;           // the constraint equation that is weak there, where the share is doubtful
  bool moves = false;     // the start velocities are not zero
  bool on_branch = true;  // false: no branch goes on with the fixed velocities
};

// Shares below which the start is worth a warning: rounding of 2e-16 in closed loops leaves 2e-16 / share^2 of the
// velocities open.
inline constexpr double doubtful_fraction = 1e-4;

// Examines the start at which `start` stands. In a singular configuration J v = b holds for more velocities than the
// mechanism can go on with: those of its branches have accelerations, J vdot = gamma(v), so that l^T gamma(v) = 0 for
// every l with l^T J = 0. There start.v becomes the nearest such velocity, fixed ones kept; elsewhere it stays.
// Leaves `dynamics` at start.q.
SingularStart examine_start(const Mechanism& mechanism, Dynamics& dynamics, const MobilityAnalysis& mobility,
                            const InitialGuess& tree, const InitialGuess& cuts, Assembled& start);

}  // namespace gelenk
