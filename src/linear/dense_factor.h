// SPDX-License-Identifier: BSD-3-Clause
// Factorizations in place, without allocation: Eigen's allocate work space for large matrices.
#pragma once

#include <Eigen/Core>

namespace gelenk {

using DenseVector = Eigen::Map<Eigen::VectorXd>;
using DenseMatrix = Eigen::Map<Eigen::MatrixXd>;

// A = L D L^T of a symmetric positive definite A, of which only the lower triangle is used. Pivots below least_pivot,
// which rounding leaves of singular matrices, are replaced by it.
void factorize_symmetric(DenseMatrix A, double least_pivot);
// x <- A^-1 x
void solve_symmetric(const DenseMatrix& A, DenseVector x);

// A <- the lower triangle of C C^T, whose columns have few nonzeros.
void lower_product(const Eigen::MatrixXd& C, Eigen::MatrixXd& A);

// P A = L U with row pivoting; pivots: A.rows() numbers. Pivots smaller than least_pivot are replaced by it.
void factorize_general(DenseMatrix A, int* pivots, double least_pivot);
// Whether the determinant of a matrix with these factors is positive.
bool has_positive_determinant(const DenseMatrix& A, const int* pivots);
void solve_general(const DenseMatrix& A, const int* pivots, DenseVector x);

}  // namespace gelenk
