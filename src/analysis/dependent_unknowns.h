// SPDX-License-Identifier: BSD-3-Clause
// Unknowns that constraint equations determine from the others, and what prescribed motions change in these equations.
#pragma once

#include <Eigen/Core>
#include <Eigen/QR>
#include <vector>

namespace gelenk {

struct Loads;
struct Mechanism;

// Relative to the largest pivot of the constraint equations in the dependent velocities: below it the rounding of the
// loop closure would cause errors of 1e-6 in the derivatives.
inline constexpr double singular_pivot_ratio = 1e-8;

// Solves the constraint equations `rows` for the unknowns `dependent`.
struct DependentUnknowns {
  std::vector<int> dependent;  // indices of velocities
  std::vector<int> rows;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factor;

  void compute(const Eigen::MatrixXd& J, int rank);
  Eigen::MatrixXd solve(const Eigen::MatrixXd& residuals, Eigen::Index nv) const;
};

// The changes of the targets of coordinate rows, or of their time derivatives of this order, by row: with the inputs
// that give them, and with the signals that they follow. u: the signals (kinematics/loads.h).
Eigen::MatrixXd changes_of_targets(const Mechanism& mechanism, const Loads& loads, const double* u, int order,
                                   const Eigen::MatrixXd& du);

}  // namespace gelenk
