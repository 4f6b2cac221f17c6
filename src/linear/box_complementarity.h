// SPDX-License-Identifier: BSD-3-Clause
// Linear complementarity with bounds: limited forces, and the motions that they prevent up to their limits.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gelenk {

struct BoxSolution {
  Eigen::VectorXd x;          // within the bounds
  Eigen::VectorXd r;          // b - W x; zero, up to rounding, for entries inside their bounds
  std::vector<int> at_bound;  // by entry: 1 at the upper bound, -1 at the lower one, 0 inside
  bool found = false;
};

// Finds lower <= x <= upper so that r = b - W x obeys
//   lower < x < upper:  r = 0,     x = upper:  r >= 0,     x = lower:  r <= 0,
// the minimum of 1/2 x^T W x - b^T x over the box (Cottle, Pang & Stone 2009, sec. 1.2), by a primal active-set method
// (Nocedal & Wright 2006, sec. 16.5). W: symmetric and positive semidefinite. Bounds: lower <= 0 <= upper; they may be
// infinite. r is unique; so is x where W is definite, else x is the one of least norm (in units in which W's diagonal
// is 1) with the same entries at bounds, if that lies in the box. tolerance: of r, relative to the largest entry of b.
// found is false where no finite x solves it: b is not in the range of W.
BoxSolution solve_in_box(const Eigen::MatrixXd& W, const Eigen::VectorXd& b, const Eigen::VectorXd& lower,
                         const Eigen::VectorXd& upper, double tolerance = 1e-12);

// The least-squares solution of W x = b of least norm. W: symmetric.
Eigen::VectorXd least_squares(const Eigen::MatrixXd& W, const Eigen::VectorXd& b);

}  // namespace gelenk
