// SPDX-License-Identifier: BSD-3-Clause
// Solutions of least norm of small systems, most of them symmetric, some of them singular.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gelenk {

// Keeps its memory: a system no larger than those before allocates nothing.
class LeastNormSolver {
 public:
  // x <- the solution of G x = r, if G is regular, or the one of least norm, if G is symmetric and positive
  // semidefinite and r in its range. threshold: pivots below this fraction of the largest count as 0. Returns false,
  // and leaves x as it is, if G is another singular matrix.
  bool solve(const Eigen::MatrixXd& G, const Eigen::VectorXd& r, double threshold, Eigen::VectorXd& x);
  // Whether the last solution is the only one.
  bool was_unique() const { return was_unique_; }

 private:
  bool solve_redundant(const Eigen::MatrixXd& G, const Eigen::VectorXd& r, double threshold, Eigen::VectorXd& x);
  bool solve_regular(const Eigen::MatrixXd& G, const Eigen::VectorXd& r, double threshold, Eigen::VectorXd& x);

  std::vector<double> rest_, factor_, gram_, y_;
  std::vector<int> pivots_;
  bool was_unique_ = false;
};

}  // namespace gelenk
