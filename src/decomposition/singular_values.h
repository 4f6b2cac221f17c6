// SPDX-License-Identifier: BSD-3-Clause
// Singular value decomposition J = U diag(sigma) V^T of a dense matrix.
#pragma once

#include <Eigen/Core>

namespace gelenk {

struct SingularValues {
  explicit SingularValues(const Eigen::MatrixXd& J);
  Eigen::MatrixXd U, V;   // square
  Eigen::VectorXd sigma;  // in descending order
  // Number of singular values above this fraction of the largest.
  Eigen::Index rank(double fraction) const;
  // The minimum-norm least-squares solution of J x = b, truncated at this rank; damped: sigma / (sigma^2 + damping)
  // replaces 1 / sigma.
  Eigen::VectorXd solve(const Eigen::VectorXd& b, Eigen::Index rank, double damping = 0) const;
};

// Combinations of constraint equations that become dependent at or near a singular configuration: orthonormal columns
// l with |l^T J| at most `threshold` times the largest singular value of J; with a threshold at rounding level, the
// left null space of J.
Eigen::MatrixXd weak_rows(const Eigen::MatrixXd& J, double threshold);

}  // namespace gelenk
