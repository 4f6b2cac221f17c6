// SPDX-License-Identifier: BSD-3-Clause
// Levenberg-Marquardt: residuals made to vanish, or as small as can be, by steps on whatever the unknowns live on
// (Nocedal & Wright 2006, ch. 10). Undamped, a step is Newton's; the more it is damped, the shorter it is and the
// nearer to steepest descent. All loops are closed by it but those of a run, which stand so near that Newton's steps in
// the mass metric, by factors that are there already, need no damping (formulation/corrector.cpp).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <utility>

namespace gelenk {

inline double largest(const Eigen::VectorXd& x) { return x.size() == 0 ? 0 : x.lpNorm<Eigen::Infinity>(); }

// The step, none of its components longer than that.
inline Eigen::VectorXd limited(Eigen::VectorXd step, double longest) {
  const double size = largest(step);
  if (size > longest) step *= longest / size;
  return step;
}

struct Descent {
  double tolerance = 0;          // of the largest residual, in its unit: up to this it has vanished
  double rounding = tolerance;   // likewise: from there on nothing is gained; so far as long as steps halve residuals
  double least_progress = 1e-6;  // share of the residuals' norm that a step takes away, if it is to be taken
  double least_damping = 0;      // as the problem measures it
  double longest_step = 0;       // in any unknown: farther the linearized problem says little
  int most_steps = 0;
};

// Until nothing is gained, no damping brings progress or the steps are used up. Returns the residuals left, which tell
// whether they have vanished: nothing that is no number counts as progress. x: where to begin, then where it ended.
//   residual(x)            what is to vanish
//   linearized(x)          step(r, damping): the step from x that makes r least, damped; empty: nothing can move
//   displaced(x, step)     x moved
template <class X, class Residual, class Linearized, class Displaced>
Eigen::VectorXd descend(X& x, const Descent& how, Residual residual, Linearized linearized, Displaced displaced) {
  constexpr double first_damping = 1e-4;  // where an undamped step has led nowhere
  constexpr double negligible = 1e-5;     // a smaller damping is given up once a step succeeds
  constexpr int most_dampings = 12;       // of one step: to 1e6, far down the gradient
  Eigen::VectorXd r = residual(x);
  double damping = how.least_damping;
  for (int i = 0; i < how.most_steps && !(largest(r) <= how.rounding); ++i) {
    const auto step = linearized(x);
    const bool vanished = largest(r) <= how.tolerance;
    const double enough = (1 - (vanished ? 0.5 : how.least_progress)) * r.norm();
    bool better = false;
    for (int k = 0; k < (vanished ? 1 : most_dampings) && !better; ++k) {
      const Eigen::VectorXd dx = limited(step(r, damping), how.longest_step);
      if (dx.size() == 0) return r;
      X next = displaced(x, dx);
      Eigen::VectorXd there = residual(next);
      better = there.norm() < enough;
      if (better) {
        x = std::move(next);
        r = std::move(there);
        damping = damping < negligible ? how.least_damping : std::max(how.least_damping, damping / 10);
      } else {
        damping = std::max(first_damping, 8 * damping);
      }
    }
    if (!better) break;
  }
  return r;
}

}  // namespace gelenk
