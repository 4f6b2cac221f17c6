// SPDX-License-Identifier: BSD-3-Clause
// Accelerations in a singular configuration, where J vdot = gamma does not determine them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dynamics/dynamics.h"

namespace gelenk {

// Along a branch of motion l^T (J vdot - gamma) = 0 for every t, also for an l with l^T J = 0 here. Its time derivative
// at constant l, l^T d/dt (J vdot - gamma) = 0, does not contain vddot, since l^T J = 0, and is linear in vdot:
// together with J vdot = gamma it replaces the lost equation, and Gauss's principle gives
//   [M A^T; A 0] [vdot; mu] = [f; c],   A: J with these additional rows.
class BranchAcceleration {
 public:
  BranchAcceleration(const Mechanism& mechanism, Dynamics& dynamics) : mechanism_(mechanism), dynamics_(dynamics) {}

  // Computes vdot (nv) at (q, v) with the inputs u. Returns false if it is not determined there. Leaves `dynamics` at
  // another position, and allocates.
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
