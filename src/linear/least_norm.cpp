// SPDX-License-Identifier: BSD-3-Clause
#include "linear/least_norm.h"

#include <algorithm>
#include <cmath>

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

bool is_symmetric(const MatrixXd& G, double largest_difference) {
  for (Index j = 0; j < G.cols(); ++j) {
    for (Index i = 0; i < j; ++i) {
      if (!(std::abs(G(i, j) - G(j, i)) <= largest_difference)) return false;
    }
  }
  return true;
}

// out <- A^T b
void multiply_transposed(const DenseMatrix& A, const double* b, DenseVector out) {
  for (Index j = 0; j < A.cols(); ++j) out[j] = A.col(j).dot(Eigen::Map<const VectorXd>(b, A.rows()));
}

// gram <- the factors of A^T A.
void factorize_gram(const DenseMatrix& A, DenseMatrix gram) {
  for (Index j = 0; j < A.cols(); ++j) {
    for (Index i = j; i < A.cols(); ++i) gram(i, j) = A.col(i).dot(A.col(j));
  }
  factorize_symmetric(gram, 0);
}

}  // namespace

void LeastNormSolver::reserve(Index size) {
  const auto n = static_cast<std::size_t>(size);
  for (std::vector<double>* of : {&rest_, &columns_, &rows_, &gram_, &row_gram_}) of->resize(n * n);
  for (std::vector<double>* of : {&y_, &error_, &pivot_values_}) of->resize(n);
  pivots_.resize(n);
  rank_ = 0;
}

void LeastNormSolver::solve(const MatrixXd& G, const VectorXd& r, VectorXd& x) {
  reserve(G.rows());
  was_unique_ = false;
  if (solve_redundant(G, r, x)) return;
  was_unique_ = solve_regular(G, r, x);
  if (!was_unique_) solve_singular(G, r, x);
}

void LeastNormSolver::solve_weighted(const MatrixXd& G, const VectorXd& r, const VectorXd& weights, VectorXd& x) {
  scaled_ = G;
  for (Index j = 0; j < G.cols(); ++j) scaled_.col(j) = weights[j] * weights.cwiseProduct(G.col(j));
  right_ = weights.cwiseProduct(r);
  solve(scaled_, right_, x);
  x.array() *= weights.array();
}

// G = L L^T, with as many columns of L as the rank: x = L (L^T L)^-2 L^T r. Regular matrices are left to the other
// method, which is more accurate.
bool LeastNormSolver::solve_redundant(const MatrixXd& G, const VectorXd& r, VectorXd& x) {
  const Index n = G.rows();
  const double largest = G.diagonal().maxCoeff();
  if (n < 2 || !(largest > 0) || !is_symmetric(G, threshold_ * largest)) return false;
  DenseMatrix rest(rest_.data(), n, n);
  rest = G;
  Index rank = 0;
  for (; rank < n; ++rank) {
    Index p = 0;
    const double pivot = rest.diagonal().maxCoeff(&p);
    if (!(pivot > threshold_ * largest)) break;
    DenseVector column(columns_.data() + rank * n, n);
    column = rest.col(p) / std::sqrt(pivot);
    for (Index j = 0; j < n; ++j) rest.col(j) -= column[j] * column;
  }
  rank_ = rank;
  const bool is_indefinite = rest.cwiseAbs().maxCoeff() > std::sqrt(threshold_) * largest;
  if (rank == n || is_indefinite) return false;
  const DenseMatrix L(columns_.data(), n, rank);
  const DenseMatrix gram(gram_.data(), rank, rank);
  const DenseVector y(y_.data(), rank);
  factorize_gram(L, gram);
  multiply_transposed(L, r.data(), y);
  solve_symmetric(gram, y);
  solve_symmetric(gram, y);
  x.setZero(n);
  for (Index j = 0; j < rank; ++j) x += y[j] * L.col(j);
  return true;
}

bool LeastNormSolver::solve_regular(const MatrixXd& G, const VectorXd& r, VectorXd& x) {
  const Index n = G.rows();
  DenseMatrix factors(rest_.data(), n, n);
  factors = G;
  factorize_general(factors, pivots_.data(), 0);
  double least = std::abs(factors(0, 0)), largest = least;
  for (Index i = 1; i < n; ++i) {
    const double pivot = std::abs(factors(i, i));
    least = std::min(least, pivot);
    largest = std::max(largest, pivot);
  }
  if (!(least > threshold_ * largest)) return false;
  DenseVector solution(y_.data(), n);
  solution = r;
  solve_general(factors, pivots_.data(), solution);
  x = solution;
  rank_ = n;
  return true;
}

// With the factors of factorize(), of which the columns are independent: x = U (U^T U)^-1 D^-1 (L^T L)^-1 L^T r; once
// more for the error that rounding leaves.
void LeastNormSolver::solve_singular(const MatrixXd& G, const VectorXd& r, VectorXd& x) {
  const Index n = G.rows();
  reserve(n);
  was_unique_ = false;
  x.setZero(n);
  const int rank = factorize(G);
  rank_ = rank;
  if (rank == 0) return;
  add_pseudo_inverse(rank, r.data(), x.data());
  DenseVector error(error_.data(), n);
  error = r;
  error -= G.lazyProduct(x);
  add_pseudo_inverse(rank, error_.data(), x.data());
}

// G = L D U^T by complete pivoting, with as many columns of L and U as the rank, which is returned.
int LeastNormSolver::factorize(const MatrixXd& G) {
  const Index n = G.rows();
  DenseMatrix rest(rest_.data(), n, n);
  rest = G;
  double largest = 0;
  int rank = 0;
  for (; rank < n; ++rank) {
    Index i = 0, j = 0;
    const double size = rest.cwiseAbs().maxCoeff(&i, &j);
    largest = std::max(largest, size);
    if (!(size > threshold_ * largest)) break;
    const double pivot = rest(i, j);
    DenseVector column(columns_.data() + rank * n, n);
    DenseVector row(rows_.data() + rank * n, n);
    column = rest.col(j) / pivot;
    row = rest.row(i).transpose() / pivot;
    pivot_values_[static_cast<std::size_t>(rank)] = pivot;
    for (Index k = 0; k < n; ++k) rest.col(k) -= (pivot * row[k]) * column;
  }
  if (rank == 0) return 0;
  factorize_gram(DenseMatrix(columns_.data(), n, rank), DenseMatrix(gram_.data(), rank, rank));
  factorize_gram(DenseMatrix(rows_.data(), n, rank), DenseMatrix(row_gram_.data(), rank, rank));
  return rank;
}

// x += the solution for r, with the factors of the last factorize().
void LeastNormSolver::add_pseudo_inverse(int rank, const double* r, double* x) {
  const auto n = static_cast<Index>(y_.size());
  const DenseMatrix U(rows_.data(), n, rank);
  DenseVector y(y_.data(), rank);
  multiply_transposed(DenseMatrix(columns_.data(), n, rank), r, y);
  solve_symmetric(DenseMatrix(gram_.data(), rank, rank), y);
  y.array() /= DenseVector(pivot_values_.data(), rank).array();
  solve_symmetric(DenseMatrix(row_gram_.data(), rank, rank), y);
  DenseVector out(x, n);
  for (Index j = 0; j < rank; ++j) out += y[j] * U.col(j);
}

}  // namespace gelenk
