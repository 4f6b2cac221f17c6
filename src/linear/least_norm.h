// SPDX-License-Identifier: BSD-3-Clause
// Solutions of least norm of small square systems, some of them singular.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "linear/dense_factor.h"

namespace gelenk {

// Keeps its memory: a system no larger than those before allocates nothing.
class LeastNormSolver {
 public:
  // threshold: pivots below this fraction of the largest count as 0.
  explicit LeastNormSolver(double threshold) : threshold_(threshold) {}

  // x <- the solution of G x = r, or if there are many the one of least norm, or if there is none the one with the
  // least error of those.
  void solve(const Eigen::MatrixXd& G, const Eigen::VectorXd& r, Eigen::VectorXd& x);
  // The same by complete pivoting, which suits all G, but takes more time.
  void solve_singular(const Eigen::MatrixXd& G, const Eigen::VectorXd& r, Eigen::VectorXd& x);
  // The same, where the norm is that of x divided by `weights`, with errors multiplied by them.
  void solve_weighted(const Eigen::MatrixXd& G, const Eigen::VectorXd& r, const Eigen::VectorXd& weights,
                      Eigen::VectorXd& x);
  // Whether the last solution is the only one.
  bool was_unique() const { return was_unique_; }
  // Of the matrix of the last solution.
  Eigen::Index rank() const { return rank_; }

 private:
  void reserve(Eigen::Index size);
  bool solve_redundant(const Eigen::MatrixXd& G, const Eigen::VectorXd& r, Eigen::VectorXd& x);
  bool solve_regular(const Eigen::MatrixXd& G, const Eigen::VectorXd& r, Eigen::VectorXd& x);
  int factorize(const Eigen::MatrixXd& G);
  void add_pseudo_inverse(int rank, const double* r, double* x);

  double threshold_;
  std::vector<double> rest_, columns_, rows_, gram_, row_gram_, y_, error_, pivot_values_;
  std::vector<int> pivots_;
  Eigen::MatrixXd scaled_;
  Eigen::VectorXd right_;
  bool was_unique_ = false;
  Eigen::Index rank_ = 0;
};

}  // namespace gelenk
