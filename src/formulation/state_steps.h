// SPDX-License-Identifier: BSD-3-Clause
// Steps of element states beside those of a motion by impulses, at one position and velocity: the two-stage SDIRK
// method of order 2 that damps what is stiff (L-stable; Alexander 1977).
#pragma once

#include <Eigen/LU>

#include "formulation/drives.h"

namespace gelenk {

class StateSteps {
 public:
  // Both must outlive it.
  StateSteps(Dynamics& dynamics, Drives& drives, int states);

  // Both take the position and velocity of `dynamics` and the inputs of `drives`, and return false if the result is not
  // finite. The first sets the element states of `drives` to those in the middle of a step of length h from z, for
  // forces; the second advances z by h.
  bool predict_middle(const double* z, double h);
  bool advance(double* z, double h);

 private:
  bool solve(const Eigen::VectorXd& from, double h);
  void rates(const Eigen::VectorXd& at);

  Dynamics& dynamics_;
  Drives& drives_;
  Eigen::VectorXd z_, stage_, residual_, rates_, displaced_;
  Eigen::MatrixXd J_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
};

}  // namespace gelenk
