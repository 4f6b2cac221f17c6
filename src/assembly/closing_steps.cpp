// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/closing_steps.h"

#include <cmath>
#include <utility>

#include "linear/dense_factor.h"
#include "linear/row_factor.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double least_pivot = 1e-300;  // of positive definite matrices

double mean_square(double squared_norm, Index rows) { return rows > 0 ? squared_norm / static_cast<double>(rows) : 0; }

VectorXd solve_definite_in_place(MatrixXd& A, VectorXd b) {
  DenseMatrix view(A.data(), A.rows(), A.cols());
  factorize_symmetric(view, least_pivot);
  solve_symmetric(view, DenseVector(b.data(), b.size()));
  return b;
}

VectorXd step(std::monostate, const VectorXd&, double) { return {}; }

VectorXd step(const SparseMatrix& G, const VectorXd& r, double shift) {
  if (shift == 0 || G.cols() == 0) return -RowSpace(G).min_norm(r);
  const SparseMatrix normal = G * G.transpose();
  return -G.transpose() * solve_definite(plus_diagonal(normal, shift), r);
}

VectorXd step(const MatrixXd& columns, const VectorXd& r, double shift) {
  const Index n = columns.rows();
  const Index m = columns.cols();
  VectorXd x = VectorXd::Zero(n);
  if (n == 0 || m == 0) return x;
  if (shift == 0) {
    RowFactor factor(static_cast<int>(n), static_cast<int>(m));
    Eigen::Map<MatrixXd>(factor.column(0), n, m) = columns;
    factor.factorize(static_cast<int>(std::min(n, m)));
    factor.min_norm(r.data(), x.data());
    return -x;
  }
  MatrixXd normal(m, m);
  normal.noalias() = columns.transpose() * columns;
  normal.diagonal().array() += shift;
  return -(columns * solve_definite_in_place(normal, r));
}

}  // namespace

ClosingStep::ClosingStep(SparseMatrix rows) : G_(std::move(rows)) {
  const auto& G = std::get<SparseMatrix>(G_);
  scale_ = mean_square(G.nonZeros() > 0 ? G.squaredNorm() : 0, G.rows());
}

ClosingStep::ClosingStep(MatrixXd columns) : G_(std::move(columns)) {
  const auto& G = std::get<MatrixXd>(G_);
  scale_ = mean_square(G.squaredNorm(), G.cols());
}

VectorXd ClosingStep::operator()(const VectorXd& r, double damping) const {
  return std::visit([&](const auto& G) { return step(G, r, damping * scale_); }, G_);
}

VectorXd relaxing_step(const MatrixXd& columns, const VectorXd& weights, const VectorXd& r, const VectorXd& d,
                       double damping) {
  if (columns.rows() == 0) return {};
  MatrixXd normal(columns.rows(), columns.rows());
  lower_product(columns, normal);
  normal.diagonal() += weights;
  normal.diagonal().array() += damping;
  return -solve_definite_in_place(normal, columns * r + weights.cwiseSqrt().cwiseProduct(d));
}

}  // namespace gelenk
