// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/redundant_impulses.h"

#include <algorithm>
#include <cmath>

#include "linear/dense_factor.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Pivots below this fraction of the largest are redundant impulses.
constexpr double redundant_pivot = 1e-9;
// What redundant contacts yield relative to how the bodies do: as little as leaves their impulses well determined,
// since the velocities are solved for to rounding; and the iterations that remove it, of which each gains three digits.
constexpr double yielding_fraction = 1e-4;
// Where a heavy body strikes a light one, what redundant contacts yield is more than how the heavy one does: it is
// reduced by this factor in each iteration, down to this part, where the rounding of the impulses would decide.
constexpr double yielding_reduction = 0.1;
constexpr double least_yielding = 1e-6;
constexpr int most_proximal_iterations = 20;
constexpr double part_of_tolerance = 1e-3;
// Problems that are small enough for many iterations, times what others may take.
constexpr int most_rows = 60;
constexpr int more_iterations = 9;

bool has_friction(const Cone& cone) { return !cone.is_ball && cone.size() > 1; }

}  // namespace

bool RedundantImpulses::are_in(const ConeProblem& problem) {
  const Index n = problem.G.size();
  factors_.assign(problem.G.dense(), problem.G.dense() + n * n);
  const DenseMatrix factors(factors_.data(), n, n);
  const double largest = factors.diagonal().maxCoeff();
  const double least = redundant_pivot * largest;
  factorize_symmetric(factors, least);
  return factors.diagonal().minCoeff() <= least;
}

// By row: how much it yields. Equal for what a turn of the axes mixes.
void RedundantImpulses::set_weights(const ConeProblem& problem) {
  const Index n = problem.G.size();
  const Eigen::Map<const Eigen::MatrixXd> G(problem.G.dense(), n, n);
  const double least = redundant_pivot * G.diagonal().maxCoeff();
  weights_.resize(static_cast<std::size_t>(n));
  const auto set = [&](Index first, Index size) {
    if (size == 0) return;
    const double mean = std::max(G.diagonal().segment(first, size).mean(), least);
    std::fill_n(weights_.begin() + first, size, yielding_fraction * mean);
  };
  for (const Cone& cone : problem.cones) {
    const Index forces = cone.forces();
    set(cone.first, forces);
    set(cone.first + forces, cone.spin);
    set(cone.first + forces + cone.spin, cone.roll);
  }
}

ConeResult RedundantImpulses::solve(ConeSolver& solver, const ConeProblem& problem, const ConeOptions& options,
                                    int most_iterations, double* x) {
  const Index n = problem.G.size();
  set_weights(problem);
  yielding_.resize(static_cast<std::size_t>(n * n));
  right_.resize(static_cast<std::size_t>(n));
  DenseMatrix yielding(yielding_.data(), n, n);
  const Eigen::Map<const Eigen::MatrixXd> G(problem.G.dense(), n, n);
  const Eigen::Map<const VectorXd> b(problem.b.data(), n);
  const DenseVector weights(weights_.data(), n);
  DenseVector impulses(x, n), right(right_.data(), n);
  before_.assign(static_cast<std::size_t>(n), 0.0);
  DenseVector before(before_.data(), n);
  ConeResult out;
  double part = 1;
  for (int k = 0; k < most_proximal_iterations; ++k) {
    if (k > 0) before = impulses;
    yielding = G;
    yielding.diagonal() += part * weights;
    right = b - part * weights.cwiseProduct(before);
    ConeOptions remaining = options;
    remaining.max_iterations = std::min(options.max_iterations, most_iterations - out.iterations);
    const DenseConeOperator of_yielding(yielding);
    const ConeResult result = solver.solve({of_yielding, right_, problem.cones, problem.exact_coulomb}, remaining, x);
    out.iterations += result.iterations;
    out.products += result.products;
    out.residual = result.residual;
    const double yields = part * weights.cwiseProduct(impulses - before).cwiseAbs().maxCoeff();
    out.converged = result.converged && yields <= options.tolerance;
    if (yields <= options.tolerance) break;
    out.residual = std::max(out.residual, yields);
    if (out.iterations >= most_iterations) break;
    if (k > 0) part = std::max(least_yielding, yielding_reduction * part);
  }
  return out;
}

ConeResult SolverOfRedundant::solve(const ConeProblem& problem, const ConeOptions& options, double* x) {
  const bool may_differ = problem.exact_coulomb && problem.G.dense() != nullptr && problem.G.size() <= most_rows &&
                          std::ranges::any_of(problem.cones, has_friction);
  if (!may_differ || !redundant_.are_in(problem)) return solver_->solve(problem, options, x);
  // Else forces would be smaller by the part that yields, in each step.
  ConeOptions accurate = options;
  accurate.tolerance *= part_of_tolerance;
  ConeResult out{.residual = INFINITY};
  const auto take = [&](ConeResult found) {
    out.iterations += found.iterations;
    out.products += found.products;
    if (found.residual < out.residual) {
      out.residual = found.residual;
      std::ranges::copy(x_, x);
    }
    return out.converged = found.residual <= options.tolerance;
  };
  start_.assign(x, x + problem.b.size());
  x_ = start_;
  if (take(redundant_.solve(*solver_, problem, accurate, options.max_iterations, x_.data()))) return out;
  x_ = start_;
  if (take(solver_->solve(problem, options, x_.data()))) return out;
  take(redundant_.solve(*solver_, problem, options, more_iterations * options.max_iterations, x_.data()));
  return out;
}

}  // namespace gelenk
