// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/force_margin.h"

#include <cmath>
#include <limits>

#include "decomposition/singular_values.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Newton steps at most, and the factor by which the weight of the margin grows after each: 2^100 is more than all
// digits of a number.
constexpr int most_barrier_steps = 100;
constexpr double growth = 2;

double margin_of(const VectorXd& x, const ForceCone& of) {
  const double normal = x[of.normal];
  return of.size == 0 ? normal : normal - x.segment(of.first, of.size).norm() / of.coefficient;
}

ForceMargin smallest_margin(const VectorXd& x, const std::vector<ForceCone>& cones) {
  ForceMargin out{.margin = std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < cones.size(); ++i) {
    const double margin = margin_of(x, cones[i]);
    if (margin < out.margin) out = {.margin = margin, .cone = i};
  }
  out.x = x;
  return out;
}

}  // namespace

MatrixXd redundant_multipliers(const MatrixXd& G) {
  const SingularValues found(G);
  return found.V.rightCols(G.cols() - found.rank(redundancy));
}

ForceMargin force_margin(const VectorXd& x, const MatrixXd& redundant, const std::vector<ForceCone>& cones,
                         double enough) {
  ForceMargin best = smallest_margin(x, cones);
  if (redundant.cols() == 0 || best.margin >= enough) return best;
  // The unknowns are the multiples of the redundant ones and s, in units of the forces.
  const double size = x.cwiseAbs().maxCoeff();
  if (!(size > 0)) return best;
  const Index n = redundant.cols();
  VectorXd w = VectorXd::Zero(n + 1);
  w[n] = best.margin / size - 1;
  double weight = 1;
  for (int step = 0; step < most_barrier_steps; ++step, weight *= growth) {
    VectorXd gradient = VectorXd::Zero(n + 1);
    MatrixXd hessian = MatrixXd::Zero(n + 1, n + 1);
    gradient[n] = -weight;
    const VectorXd now = x / size + redundant * w.head(n);
    for (const ForceCone& of : cones) {
      VectorXd by_normal(n + 1);
      by_normal << redundant.row(of.normal).transpose(), -1.0;
      const double normal = now[of.normal] - w[n];
      double distance = normal;
      VectorXd first = by_normal;
      MatrixXd curvature = MatrixXd::Zero(n + 1, n + 1);
      if (of.size > 0) {
        const double square = of.coefficient * of.coefficient;
        const VectorXd friction = now.segment(of.first, of.size);
        MatrixXd by_friction = MatrixXd::Zero(of.size, n + 1);
        by_friction.leftCols(n) = redundant.middleRows(of.first, of.size);
        distance = square * normal * normal - friction.squaredNorm();
        first = 2 * (square * normal * by_normal - by_friction.transpose() * friction);
        curvature = 2 * (square * by_normal * by_normal.transpose() - by_friction.transpose() * by_friction);
      }
      gradient -= first / distance;
      hessian += first * first.transpose() / (distance * distance) - curvature / distance;
    }
    const SingularValues factors(hessian);
    const VectorXd dw = -factors.solve(gradient, factors.rank(0));
    if (!dw.allFinite()) break;
    // Damped, so that it remains inside.
    const double decrement = std::sqrt(std::max(0.0, -gradient.dot(dw)));
    w += dw / (1 + decrement);
    const ForceMargin found = smallest_margin(x + size * redundant * w.head(n), cones);
    if (found.margin > best.margin) best = found;
    if (best.margin >= enough) break;
  }
  return best;
}

}  // namespace gelenk
