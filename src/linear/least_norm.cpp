// SPDX-License-Identifier: BSD-3-Clause
#include "linear/least_norm.h"

#include <algorithm>
#include <cmath>

#include "linear/dense_factor.h"

namespace gelenk {
namespace {

using Eigen::Index;

bool is_symmetric(const Eigen::MatrixXd& G, double largest_difference) {
  for (Index j = 0; j < G.cols(); ++j) {
    for (Index i = 0; i < j; ++i) {
      if (!(std::abs(G(i, j) - G(j, i)) <= largest_difference)) return false;
    }
  }
  return true;
}

}  // namespace

bool LeastNormSolver::solve(const Eigen::MatrixXd& G, const Eigen::VectorXd& r, double threshold, Eigen::VectorXd& x) {
  for (std::vector<double>* of : {&rest_, &factor_, &gram_}) of->resize(static_cast<std::size_t>(G.size()));
  y_.resize(static_cast<std::size_t>(G.rows()));
  pivots_.resize(y_.size());
  was_unique_ = false;
  if (solve_redundant(G, r, threshold, x)) return true;
  return was_unique_ = solve_regular(G, r, threshold, x);
}

// G = L L^T, with as many columns of L as the rank: x = L (L^T L)^-2 L^T r. Regular matrices are left to the other
// method, which is more accurate.
bool LeastNormSolver::solve_redundant(const Eigen::MatrixXd& G, const Eigen::VectorXd& r, double threshold,
                                      Eigen::VectorXd& x) {
  const Index n = G.rows();
  const double largest = G.diagonal().maxCoeff();
  if (n < 2 || !(largest > 0) || !is_symmetric(G, threshold * largest)) return false;
  DenseMatrix rest(rest_.data(), n, n);
  rest = G;
  Index rank = 0;
  for (; rank < n; ++rank) {
    Index p = 0;
    const double pivot = rest.diagonal().maxCoeff(&p);
    if (!(pivot > threshold * largest)) break;
    DenseVector column(factor_.data() + rank * n, n);
    column = rest.col(p) / std::sqrt(pivot);
    for (Index j = 0; j < n; ++j) rest.col(j) -= column[j] * column;
  }
  const bool is_indefinite = rest.cwiseAbs().maxCoeff() > std::sqrt(threshold) * largest;
  if (rank == n || is_indefinite) return false;
  const DenseMatrix L(factor_.data(), n, rank);
  DenseMatrix gram(gram_.data(), rank, rank);
  DenseVector y(y_.data(), rank);
  for (Index j = 0; j < rank; ++j) {
    for (Index i = j; i < rank; ++i) gram(i, j) = L.col(i).dot(L.col(j));
    y[j] = L.col(j).dot(r);
  }
  factorize_symmetric(gram, 0);
  solve_symmetric(gram, y);
  solve_symmetric(gram, y);
  x.setZero(n);
  for (Index j = 0; j < rank; ++j) x += y[j] * L.col(j);
  return true;
}

bool LeastNormSolver::solve_regular(const Eigen::MatrixXd& G, const Eigen::VectorXd& r, double threshold,
                                    Eigen::VectorXd& x) {
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
  if (!(least > threshold * largest)) return false;
  DenseVector solution(y_.data(), n);
  solution = r;
  solve_general(factors, pivots_.data(), solution);
  x = solution;
  return true;
}

}  // namespace gelenk
