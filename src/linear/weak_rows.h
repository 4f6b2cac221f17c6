// SPDX-License-Identifier: BSD-3-Clause
// Combinations of constraint equations that become dependent at or near a singular configuration.
#pragma once

#include <Eigen/SVD>

namespace gelenk {

// Orthonormal columns l with |l^T J| at most `threshold` times the largest singular value of J; with a threshold at
// rounding level, the left null space of J.
inline Eigen::MatrixXd weak_rows(const Eigen::MatrixXd& J, double threshold) {
  if (J.rows() == 0) return {};
  if (J.cols() == 0) return Eigen::MatrixXd::Identity(J.rows(), J.rows());
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(J, Eigen::ComputeFullU);
  const auto& sigma = svd.singularValues();
  const Eigen::Index regular_count = (sigma.array() > threshold * sigma[0]).count();
  return svd.matrixU().rightCols(J.rows() - regular_count);
}

}  // namespace gelenk
