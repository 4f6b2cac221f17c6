// SPDX-License-Identifier: BSD-3-Clause
// Decompositions of dense matrices behind plain functions: compilers need some seconds for the templates of each, so
// that they are instantiated in one file. For what runs once, or at events; steps have factors of their own.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

namespace gelenk {

// Pivots up to this fraction of the largest are 0; as rounding permits: a few roundings for each row.
inline constexpr double as_rounding_permits = 0;

// The x of least norm of those with the least |A x - b|.
Eigen::VectorXd least_norm_solution(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                                    double threshold = as_rounding_permits);
// Number of independent columns.
Eigen::Index column_rank(const Eigen::MatrixXd& A, double threshold);
// That many of them, the largest first.
std::vector<Eigen::Index> independent_columns(const Eigen::MatrixXd& A, double threshold);
// Orthonormal columns that span the x with A x = 0.
Eigen::MatrixXd null_space(const Eigen::MatrixXd& A, double threshold);
// The solution of A X = B: A is regular.
Eigen::MatrixXd solution(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
// The same where A is symmetric and positive or negative semidefinite.
Eigen::VectorXd symmetric_solution(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& A);

// Of a symmetric matrix, in increasing order.
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& A);
struct SymmetricEigen {
  explicit SymmetricEigen(const Eigen::MatrixXd& A);
  Eigen::VectorXd values;   // in increasing order
  Eigen::MatrixXd vectors;  // orthonormal columns
};

}  // namespace gelenk
