// SPDX-License-Identifier: BSD-3-Clause
// Start positions at or near a singular configuration (a change point or a dead center), where branches of motion meet.
#pragma once

#include "analysis/mobility.h"
#include "assembly/assembly.h"

namespace gelenk {

struct SingularStart {
  double pivot_fraction = 1;  // smallest pivot of the constraint Jacobian relative to the best known; 0: rank is lost
  int row = -1;               // the weakest constraint equation there, if the fraction is below doubtful_fraction
  bool moves = false;         // the start velocities are not zero
  bool on_branch = true;      // false: no branch continues with the fixed velocities
};

// Fraction below which a warning is given: rounding of 2e-16 in closed loops leaves an error of 2e-16 /
// pivot_fraction^2 in the velocities.
inline constexpr double doubtful_fraction = 1e-4;

// Examines the start position and velocities. In a singular configuration J v = b holds for more velocities than the
// mechanism can have: those of its branches have accelerations, J vdot = gamma(v), so that l^T gamma(v) = 0 for every l
// with l^T J = 0. There start.v is replaced by the nearest such velocity with fixed ones kept; elsewhere it is
// unchanged.
// Leaves `dynamics` at start.q.
SingularStart examine_start(const Mechanism& mechanism, Dynamics& dynamics, const MobilityAnalysis& mobility,
                            const InitialGuess& tree, const InitialGuess& cuts, Assembled& start);

}  // namespace gelenk
