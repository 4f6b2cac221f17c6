// SPDX-License-Identifier: BSD-3-Clause
#include "linear/least_load.h"

#include <cmath>

#include "linear/box_complementarity.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int max_iterations = 50;
// Of the part of b that the forces do not balance: rounding.
constexpr double balance_tolerance = 1e-13;

VectorXd scaled(const VectorXd& bounds, double fraction) {
  return bounds.unaryExpr([&](double x) { return std::isfinite(x) ? fraction * x : x; });
}

}  // namespace

VectorXd least_load(const Eigen::MatrixXd& W, const VectorXd& b, const VectorXd& lower, const VectorXd& upper) {
  const double size = b.cwiseAbs().maxCoeff();
  VectorXd out = least_squares(W, b);
  if (size == 0) return out;
  double fraction = 0;
  for (int i = 0; i < max_iterations; ++i) {
    const BoxSolution found = solve_in_box(W, b, scaled(lower, fraction), scaled(upper, fraction));
    if (!found.found) break;
    out = found.x;
    const VectorXd& motion = found.r;
    if (motion.cwiseAbs().maxCoeff() <= balance_tolerance * size) break;
    // The motion W a needs the power b.a, and the forces give at most the sum of bound_i (W a)_i: a lower bound.
    double resistance = 0;
    for (Index k = 0; k < motion.size(); ++k) {
      const double bound = motion[k] > 0 ? upper[k] : lower[k];
      if (std::isfinite(bound)) resistance += bound * motion[k];
    }
    const double next = least_squares(W, motion).dot(b) / resistance;
    if (!(next > fraction) || !std::isfinite(next)) break;
    fraction = next;
  }
  return out;
}

}  // namespace gelenk
