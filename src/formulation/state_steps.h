// SPDX-License-Identifier: BSD-3-Clause
// Steps of element states beside those of a motion by impulses: the implicit midpoint rule, which is of order 2 and
// stable for stiff circuits.
#pragma once

#include <Eigen/LU>
#include <vector>

#include "formulation/drives.h"

namespace gelenk {

class StateSteps {
 public:
  // Both must outlive it.
  StateSteps(Dynamics& dynamics, Drives& drives, int states);

  // Sets the element states of `drives` to those in the middle of a step of length h from z, at the present position
  // and velocity of `dynamics` and with the inputs of `drives`. Returns false if Newton's method does not converge.
  bool find_middle(const double* z, double h);
  // Then advances z over that step.
  void finish(double* z) const;

 private:
  void rates(const Eigen::VectorXd& at);

  Dynamics& dynamics_;
  Drives& drives_;
  Eigen::VectorXd middle_, residual_, rates_, displaced_;
  Eigen::MatrixXd J_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
};

}  // namespace gelenk
