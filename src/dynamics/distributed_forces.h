// SPDX-License-Identifier: BSD-3-Clause
// The forces that keep coordinates at rest, and what friction and contact can exert.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dynamics/switching_forces.h"

namespace gelenk {

struct HoldingBounds {
  Eigen::VectorXd lower, upper;  // by element of `locks`
};

// What friction at rest and contact can exert along these locks: friction up to its limit, and contact, which does not
// pull. contacts: by lock; 1, -1: with the upper, the lower bound; 0: none.
HoldingBounds holding_bounds(const SwitchingForces& forces, const std::vector<int>& locks,
                             const std::vector<int>& contacts);

// The forces along these locks after a solve(); where they are redundant, distributed so that bounds are used the least
// (linear/least_load.h). Overwrites the multipliers of that solve().
Eigen::VectorXd distributed_forces(SwitchingForces& forces, const std::vector<int>& locks, const HoldingBounds& bounds);

}  // namespace gelenk
