// SPDX-License-Identifier: BSD-3-Clause
#include "linear/least_load.h"

#include "linear/box_complementarity.h"

namespace gelenk {
namespace {

constexpr int max_iterations = 50;
// Of the part of b that the forces do not balance: rounding.
constexpr double balance_tolerance = 1e-13;

}  // namespace

Eigen::VectorXd least_load(const Eigen::MatrixXd& W, const Eigen::VectorXd& b, const Eigen::VectorXd& limits) {
  const double size = b.cwiseAbs().maxCoeff();
  Eigen::VectorXd out = least_squares(W, b);
  if (size == 0) return out;
  // A motion W a needs the power b.a, and the forces give at most the sum of limit_i |(W a)_i|: a lower bound.
  Eigen::VectorXd motion = b;
  double fraction = 0;
  for (int i = 0; i < max_iterations; ++i) {
    const double next = least_squares(W, motion).dot(b) / limits.dot(motion.cwiseAbs());
    if (!(next > fraction)) break;
    fraction = next;
    const BoxSolution found = solve_in_box(W, b, -fraction * limits, fraction * limits);
    if (!found.found) break;
    out = found.x;
    motion = found.r;
    if (motion.cwiseAbs().maxCoeff() <= balance_tolerance * size) break;
  }
  return out;
}

}  // namespace gelenk
