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

// The forces along locks after a solve(); where they are redundant, distributed so that bounds are used the least
// (linear/least_load.h). They are asked for several times in a step, most often under the same conditions, as a
// mechanism that is held stays where it is; to distribute them again costs many times an evaluation, so that the last
// result is kept.
class DistributedForces {
 public:
  // contacts: as of holding_bounds(). Overwrites the multipliers of that solve(). The result holds until the next call.
  const Eigen::VectorXd& find(SwitchingForces& forces, const std::vector<int>& locks, const std::vector<int>& contacts);

 private:
  // Those of the last result.
  Eigen::MatrixXd W_;
  Eigen::VectorXd b_;
  HoldingBounds bounds_;
  Eigen::VectorXd x_;
  // Of this call.
  Eigen::MatrixXd W_now_;
  Eigen::VectorXd b_now_, scale_, x_now_;
  HoldingBounds bounds_now_;
};

}  // namespace gelenk
