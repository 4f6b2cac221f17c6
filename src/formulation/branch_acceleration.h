// SPDX-License-Identifier: BSD-3-Clause
// Accelerations in a singular configuration, where J vdot = gamma does not determine them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dynamics/dynamics.h"

namespace gelenk {

// Along a branch of motion l^T (J vdot - gamma) vanishes for every t, also for an l with l^T J = 0 here. Its time
// derivative, l^T d/dt (J vdot - gamma) = 0 with l held, does not hold vddot, as l^T J = 0, and is linear in vdot: so
// beside J vdot = gamma it stands in for the equation that is lost, and Gauss's principle does the rest,
//   [M A^T; A 0] [vdot; mu] = [f; c],   A: J, and the rows found so.
class BranchAcceleration {
 public:
  BranchAcceleration(const Mechanism& mechanism, Dynamics& dynamics) : mechanism_(mechanism), dynamics_(dynamics) {}

  // vdot at (q, v) under the inputs u. False: it is not determined there. Leaves `dynamics` elsewhere, and allocates.
  bool find(const double* q, const double* v, const double* u, double* vdot);

 private:
  Eigen::VectorXd excess_rate(const Eigen::VectorXd& vdot);

  const Mechanism& mechanism_;
  Dynamics& dynamics_;
  std::vector<double> q_;
  Eigen::VectorXd v_;
  Eigen::MatrixXd l_;
};

}  // namespace gelenk
