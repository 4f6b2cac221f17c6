// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/rest_first.h"

#include <algorithm>

#include "complementarity/iteration.h"

namespace gelenk {

bool RestFirst::all_stick(std::span<const Cone> cones, const double* x, const double* u, double tolerance) {
  const auto slides = [&](const Cone& cone) {
    return !cone.interval && !cone.is_ball && x[cone.first] > 0 && lift_of(cone, u) > tolerance;
  };
  return std::ranges::none_of(cones, slides);
}

ConeResult RestFirst::solve(ConeSolver& solver, const ConeProblem& problem, const ConeOptions& options, double rest,
                            double* x) {
  held_.assign(x, x + problem.G.size());
  u_.resize(held_.size());
  ConeProblem convex = problem;
  convex.exact_coulomb = false;
  ConeOptions first = options, then = options;
  first.max_iterations = options.max_iterations / 4;
  const ConeResult held = solver.solve(convex, first, held_.data());
  problem.G.apply(held_.data(), u_.data());
  for (std::size_t i = 0; i < u_.size(); ++i) u_[i] += problem.b[i];
  if (held.converged && all_stick(problem.cones, held_.data(), u_.data(), rest)) {
    std::ranges::copy(held_, x);
    return held;
  }
  then.max_iterations -= held.iterations;
  ConeResult result = solver.solve(problem, then, x);
  result.iterations += held.iterations;
  return result;
}

}  // namespace gelenk
