// SPDX-License-Identifier: BSD-3-Clause
// The Levenberg-Marquardt method for nonlinear least squares (Nocedal & Wright 2006, ch. 10), on any set of unknowns
// that steps can displace (rotations included). An undamped step is a Newton step; damping shortens it and turns it
// toward steepest descent. All loops are closed with it, except during a run: there the state is so close to the
// constraints that undamped Newton steps in the mass metric, with the existing factors, suffice
// (formulation/corrector.cpp).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <utility>

namespace gelenk {

// The maximum norm of x; 0 if it is empty.
inline double largest(const Eigen::VectorXd& x) { return x.size() == 0 ? 0 : x.lpNorm<Eigen::Infinity>(); }

// The step, scaled so that none of its components exceeds `longest`.
inline Eigen::VectorXd limited(Eigen::VectorXd step, double longest) {
  const double size = largest(step);
  if (size > longest) step *= longest / size;
  return step;
}

struct Descent {
  double tolerance = 0;         // of the largest residual, in its unit: below it the equations count as solved
  double rounding = tolerance;  // as `tolerance`: iteration goal, pursued while each step halves the residual norm
  double min_progress = 1e-6;   // fraction of the residual norm that an accepted step must remove
  double min_damping = 0;       // in the scale of the function `linearized`
  double max_step = 0;          // in any unknown: beyond it the linearization is not valid
  int max_steps = 0;
};

// Iterates until the residuals are at rounding level, no damping makes progress, or max_steps are taken. Returns the
// remaining residuals, which show whether the method converged; residuals that are not finite are never accepted.
// x: the initial guess on entry, the result on return.
//   residual(x)            the residuals
//   linearized(x)          a function step(r, damping): the damped least-squares step from x; empty: nothing can move
//   displaced(x, step)     x displaced by the step
template <class X, class Residual, class Linearized, class Displaced>
Eigen::VectorXd descend(X& x, const Descent& options, Residual residual, Linearized linearized, Displaced displaced) {
  constexpr double first_damping = 1e-4;       // after an undamped step that made no progress
  constexpr double negligible_damping = 1e-5;  // a smaller damping is dropped once a step succeeds
  constexpr int max_trials = 12;               // of damping, for one step: up to 1e6, practically steepest descent
  Eigen::VectorXd r = residual(x);
  double damping = options.min_damping;
  for (int i = 0; i < options.max_steps && !(largest(r) <= options.rounding); ++i) {
    const auto step = linearized(x);
    const bool converged = largest(r) <= options.tolerance;
    const double target_norm = (1 - (converged ? 0.5 : options.min_progress)) * r.norm();
    bool improved = false;
    for (int k = 0; k < (converged ? 1 : max_trials) && !improved; ++k) {
      const Eigen::VectorXd dx = limited(step(r, damping), options.max_step);
      if (dx.size() == 0) return r;
      X next = displaced(x, dx);
      Eigen::VectorXd next_r = residual(next);
      improved = next_r.norm() < target_norm;
      if (improved) {
        x = std::move(next);
        r = std::move(next_r);
        damping = damping < negligible_damping ? options.min_damping : std::max(options.min_damping, damping / 10);
      } else {
        damping = std::max(first_damping, 8 * damping);
      }
    }
    if (!improved) break;
  }
  return r;
}

}  // namespace gelenk
