// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/redundant_impulses.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
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
// Where a solver has not converged: of problems that are small enough for many iterations, times what it may take.
constexpr Index most_improved_rows = 60;
constexpr int more_iterations = 10;

}  // namespace

VectorXd yielding_weights(const Eigen::Ref<const MatrixXd>& G, std::span<const Cone> cones) {
  const VectorXd pivots = G.ldlt().vectorD().cwiseAbs();
  if (!(pivots.minCoeff() <= redundant_pivot * pivots.maxCoeff())) return {};
  VectorXd weights(G.rows());
  const double least = redundant_pivot * G.diagonal().maxCoeff();
  const auto set = [&](Index first, Index size) {
    if (size > 0) weights.segment(first, size).setConstant(std::max(G.diagonal().segment(first, size).mean(), least));
  };
  for (const Cone& cone : cones) {
    const Index forces = cone.forces();
    set(cone.first, forces);
    set(cone.first + forces, cone.spin);
    set(cone.first + forces + cone.spin, cone.roll);
  }
  return yielding_fraction * weights;
}

ConeResult solve_redundant(ConeSolver& solver, const Eigen::Ref<const MatrixXd>& G, const VectorXd& weights,
                           const Eigen::Ref<const VectorXd>& b, std::span<const Cone> cones, const ConeOptions& options,
                           int most_iterations, double* x) {
  Eigen::Map<VectorXd> impulses(x, b.size());
  impulses.setZero();
  ConeResult out;
  double part = 1;
  for (int k = 0; k < most_proximal_iterations; ++k) {
    const VectorXd before = impulses;
    const VectorXd present = part * weights;
    MatrixXd yielding = G;
    yielding.diagonal() += present;
    const DenseConeOperator of_yielding(yielding);
    const VectorXd right = b - present.cwiseProduct(before);
    const std::span<const double> known(right.data(), static_cast<std::size_t>(right.size()));
    ConeOptions remaining = options;
    remaining.max_iterations = std::min(options.max_iterations, most_iterations - out.iterations);
    const ConeResult result = solver.solve({of_yielding, known, cones, true}, remaining, x);
    out.iterations += result.iterations;
    out.residual = result.residual;
    const double yields = present.cwiseProduct(impulses - before).cwiseAbs().maxCoeff();
    if (yields <= options.tolerance) break;
    out.residual = std::max(out.residual, yields);
    if (out.iterations >= most_iterations) break;
    if (k > 0) part = std::max(least_yielding, yielding_reduction * part);
  }
  return out;
}

ConeResult improve_redundant(ConeSolver& solver, const ConeProblem& problem, const ConeOptions& options,
                             const ConeResult& found, double* x) {
  const auto n = static_cast<Index>(problem.b.size());
  if (problem.G.dense() == nullptr || n > most_improved_rows) return found;
  const Eigen::Map<const MatrixXd> G(problem.G.dense(), n, n);
  const VectorXd weights = yielding_weights(G, problem.cones);
  if (weights.size() == 0) return found;
  const VectorXd before = Eigen::Map<const VectorXd>(x, n);
  const Eigen::Map<const VectorXd> b(problem.b.data(), n);
  ConeResult out =
      solve_redundant(solver, G, weights, b, problem.cones, options, more_iterations * options.max_iterations, x);
  out.iterations += found.iterations;
  if (out.residual < found.residual) return out;
  Eigen::Map<VectorXd>(x, n) = before;
  out.residual = found.residual;
  return out;
}

}  // namespace gelenk
