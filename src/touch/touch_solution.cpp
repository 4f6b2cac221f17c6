// SPDX-License-Identifier: BSD-3-Clause
#include "touch/touch_solution.h"

#include <Eigen/QR>

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Pivots below this fraction of the largest are redundant forces.
constexpr double rank_threshold = 1e-11;

}  // namespace

VectorXd redundant_solution(const MatrixXd& G, const VectorXd& r) {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> cod;
  cod.setThreshold(rank_threshold);
  cod.compute(G);
  return cod.solve(r);
}

VectorXd least_norm_solution(LeastNormSolver& solver, const MatrixXd& G, const VectorXd& r, const VectorXd& weights) {
  const VectorXd right = weights.asDiagonal() * r;
  const MatrixXd scaled = weights.asDiagonal() * G * weights.asDiagonal();
  VectorXd x;
  if (!solver.solve(scaled, right, rank_threshold, x)) x = redundant_solution(scaled, right);
  return weights.asDiagonal() * x;
}

}  // namespace gelenk
