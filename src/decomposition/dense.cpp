// SPDX-License-Identifier: BSD-3-Clause
#include "decomposition/dense.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Eigen::ColPivHouseholderQR<MatrixXd> pivoted(const MatrixXd& A, double threshold) {
  Eigen::ColPivHouseholderQR<MatrixXd> out(A);
  if (threshold > 0) out.setThreshold(threshold);
  return out;
}

}  // namespace

VectorXd least_norm_solution(const MatrixXd& A, const VectorXd& b, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> factor(A.rows(), A.cols());
  if (threshold > 0) factor.setThreshold(threshold);
  return factor.compute(A).solve(b);
}

Index column_rank(const MatrixXd& A, double threshold) { return pivoted(A, threshold).rank(); }

std::vector<Index> independent_columns(const MatrixXd& A, double threshold) {
  const Eigen::ColPivHouseholderQR<MatrixXd> qr = pivoted(A, threshold);
  const auto& order = qr.colsPermutation().indices();
  return {order.begin(), order.begin() + qr.rank()};
}

MatrixXd null_space(const MatrixXd& A, double threshold) {
  const Index n = A.cols();
  if (A.rows() == 0 || n == 0) return MatrixXd::Identity(n, n);
  const Eigen::ColPivHouseholderQR<MatrixXd> qr = pivoted(A.transpose(), threshold);
  const MatrixXd Q = qr.householderQ() * MatrixXd::Identity(n, n);
  return Q.rightCols(n - qr.rank());
}

MatrixXd solution(const MatrixXd& A, const MatrixXd& B) { return A.partialPivLu().solve(B); }

VectorXd symmetric_solution(const MatrixXd& A, const VectorXd& b) { return A.ldlt().solve(b); }

Eigen::VectorXcd eigenvalues(const MatrixXd& A) { return A.eigenvalues(); }

VectorXd symmetric_eigenvalues(const MatrixXd& A) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

SymmetricEigen::SymmetricEigen(const MatrixXd& A) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(A);
  values = solver.eigenvalues();
  vectors = solver.eigenvectors();
}

}  // namespace gelenk
