// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/loop_closure.h"

#include <algorithm>
#include <cmath>

#include "assembly/closing_steps.h"
#include "decomposition/dense.h"
#include "linear/descent.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double rounding_error = 2e-16;     // relative to the mechanism's length
constexpr double longest_step = 0.4;         // rad or m: the linearized loop equations are inaccurate beyond
constexpr double difference_step = 1e-5;     // of second derivatives: balances rounding and truncation
constexpr Eigen::Index max_newton_dof = 30;  // degrees of freedom up to which second derivatives are worth their cost

ClosingStep closing_step(AssemblyProblem& problem, const std::vector<double>& q) {
  if (problem.is_small()) return ClosingStep(problem.gap_columns(q));
  return ClosingStep(problem.gap_jacobian(q));
}

// Gradient of half the squared distance along the loops closed at q.
struct Gradient {
  explicit Gradient(const SparseMatrix& G) : loops(G) {}
  RowSpace loops;
  VectorXd d;         // distances
  SparseMatrix T;     // their Jacobian
  VectorXd whole;     // the gradient without the loop equations
  VectorXd gradient;  // its components along the null-space basis or, if that is too wide, its projection
};

Gradient gradient_at(AssemblyProblem& problem, const std::vector<double>& q) {
  Gradient out(problem.gap_jacobian(q));
  if (out.loops.degrees_of_freedom() == 0) return out;
  out.d = problem.distance(q);
  out.T = problem.distance_jacobian(q);
  out.whole = out.T.transpose() * out.d;
  out.gradient =
      out.loops.has_basis() ? out.loops.basis().transpose() * out.whole : out.loops.null_space_part(out.whole);
  return out;
}

// Z^T H Z with H the Hessian of the Lagrangian and Z the basis, by central differences of its gradient.
MatrixXd reduced_hessian(AssemblyProblem& problem, const std::vector<double>& q, const Gradient& at,
                         const MatrixXd& Z) {
  VectorXd lambda;  // balances the part of the gradient that the loops block
  if (at.loops.rows().rows() > 0) lambda = at.loops.multipliers(-at.whole);
  const auto gradient = [&](const VectorXd& step) {
    const std::vector<double> neighbor = problem.displaced(q, step);
    VectorXd out = problem.distance_jacobian(neighbor).transpose() * problem.distance(neighbor);
    if (lambda.size() > 0) out += problem.gap_jacobian(neighbor).transpose() * lambda;
    return out;
  };
  const double h = difference_step * problem.length();
  MatrixXd H(Z.cols(), Z.cols());
  for (Eigen::Index k = 0; k < H.cols(); ++k) {
    const VectorXd z = h * Z.col(k);
    H.col(k) = Z.transpose() * (gradient(z) - gradient(-z)) / (2 * h);
  }
  return (H + H.transpose()) / 2;
}

// Newton step with the absolute values of the curvatures: a descent direction also where the distance is not convex.
VectorXd newton_step(AssemblyProblem& problem, const std::vector<double>& q, const Gradient& at) {
  const MatrixXd& Z = at.loops.basis();
  const SymmetricEigen eigen(reduced_hessian(problem, q, at, Z));
  const VectorXd& curvatures = eigen.values;
  const double least = 1e-9 * curvatures.cwiseAbs().maxCoeff();
  VectorXd along = eigen.vectors.transpose() * at.gradient;
  for (Eigen::Index k = 0; k < along.size(); ++k) along[k] /= std::max({std::abs(curvatures[k]), least, 1e-300});
  return -(Z * (eigen.vectors * along));
}

// One step of minimize_distance, shortened until the distance decreases; returns false if it never does.
bool try_step(AssemblyProblem& problem, std::vector<double>& q, Gradient& at, VectorXd step, bool newton) {
  const double cost = at.d.squaredNorm();
  for (int k = 0; k < 8; ++k, step /= 4) {
    if (largest(step) < 1e-13 * problem.length()) return false;
    std::vector<double> next = problem.displaced(q, step);
    if (!(close_loops(problem, next) <= assembled_gap)) continue;  // also rejects NaN
    const double next_cost = problem.distance(next).squaredNorm();
    // Near the minimum the distance is constant within rounding, but its gradient still shows progress.
    if (!(next_cost < cost * (newton ? 1 + 1e-12 : 1))) continue;
    Gradient there = gradient_at(problem, next);
    if (next_cost >= cost && there.gradient.norm() > 0.5 * at.gradient.norm()) continue;
    q = std::move(next);
    at = std::move(there);
    return true;
  }
  return false;
}

}  // namespace

VectorXd nearest_velocities(const AssemblyProblem::VelocityEquations& s, double threshold) {
  const RowSpace loops(s.G, threshold);
  const VectorXd v = -loops.min_norm(s.g0);
  return loops.degrees_of_freedom() > 0 ? VectorXd(v + nearest(loops, s.T, s.T * v + s.d0, s.given)) : v;
}

double close_loops(AssemblyProblem& problem, std::vector<double>& q, const ClosingLimits& limits) {
  // Near a singular configuration a closure error of 1e-13 leaves an error of 3e-7 in a coordinate, so iteration
  // continues after convergence as long as it makes progress; there Newton's method quarters the error at each step.
  const Descent how{.tolerance = closure_tolerance * problem.length(),
                    .rounding = rounding_error * problem.length(),
                    .max_step = longest_step,
                    .max_steps = limits.steps};
  const auto goes_too_far = [&](const auto& at) {
    if (std::isinf(limits.within.given) && std::isinf(limits.within.other)) return false;
    const AssemblyProblem::Squared moved = problem.squared_tree_distance(at);
    return moved.given > limits.within.given || moved.other > limits.within.other;
  };
  return largest(descend(
      q, how, [&](const auto& at) { return problem.gap(at); },
      [&](const auto& at) { return goes_too_far(at) ? ClosingStep() : closing_step(problem, at); },
      [&](const auto& at, const VectorXd& step) { return problem.displaced(at, step); }));
}

bool close_rows(const Mechanism& mechanism, Dynamics& dynamics, std::vector<double>& q) {
  double length = 1;
  for (const Link& link : mechanism.links) length += link.X_PJ.p.norm();
  const Descent how{.tolerance = closure_tolerance * length,
                    .min_damping = 1e-10,  // pivots below its square root belong to redundant constraints
                    .max_step = longest_step,
                    .max_steps = 60};
  const auto residual = [&](const auto& at) {
    dynamics.set_position(at.data());
    return VectorXd(Eigen::Map<const VectorXd>(dynamics.Phi().data(), mechanism.rows));
  };
  const auto linearized = [&](const auto& at) {
    dynamics.set_position(at.data());
    return ClosingStep(dynamics.sparse_J());
  };
  const auto displaced = [&](auto at, const VectorXd& step) {
    dynamics.displace(at.data(), step.data());
    return at;
  };
  return largest(descend(q, how, residual, linearized, displaced)) <= how.tolerance;
}

namespace {

// Of relax(): low accuracy suffices. The damping keeps coordinates that neither loops nor guesses determine near their
// values.
constexpr Descent relaxation = {.min_progress = 0.01, .min_damping = 1e-4, .max_step = longest_step, .max_steps = 40};

VectorXd joined(const VectorXd& a, const VectorXd& b) { return (VectorXd(a.size() + b.size()) << a, b).finished(); }

// For small problems.
double relax_in_full(AssemblyProblem& problem, std::vector<double>& q) {
  const VectorXd& weights = problem.tree_weights();
  const auto residual = [&](const auto& at) {
    const VectorXd rows = joined(problem.gap(at), problem.cut_distance(at));
    return joined(rows, problem.tree_distance(at));
  };
  const auto linearized = [&](const auto& at) {
    const MatrixXd& gap = problem.gap_columns(at);
    const MatrixXd& cuts = problem.cut_distance_columns(at);
    MatrixXd all(gap.rows(), gap.cols() + cuts.cols());
    all << gap, cuts;
    return [&weights, all](const VectorXd& r, double damping) {
      return relaxing_step(all, weights, r.head(all.cols()), r.tail(weights.size()), damping);
    };
  };
  return descend(q, relaxation, residual, linearized,
                 [&](const auto& at, const VectorXd& step) { return problem.displaced(at, step); })
      .squaredNorm();
}

}  // namespace

double relax(AssemblyProblem& problem, std::vector<double>& q) {
  if (problem.is_small()) return relax_in_full(problem, q);
  const auto residual = [&](const auto& at) {
    const VectorXd g = problem.gap(at);
    return joined(g, problem.distance(at));
  };
  const auto linearized = [&](const auto& at) {
    return [G = problem.gap_jacobian(at), T = problem.distance_jacobian(at)](const VectorXd& r,
                                                                             double damping) -> VectorXd {
      if (G.cols() == 0) return {};
      const VectorXd downhill = G.transpose() * r.head(G.rows()) + T.transpose() * r.tail(T.rows());
      return -solve_normal(G, T, damping, downhill);
    };
  };
  return descend(q, relaxation, residual, linearized,
                 [&](const auto& at, const VectorXd& step) { return problem.displaced(at, step); })
      .squaredNorm();
}

void minimize_distance(AssemblyProblem& problem, std::vector<double>& q) {
  Gradient at = gradient_at(problem, q);
  for (int i = 0; i < 100 && at.loops.degrees_of_freedom() > 0; ++i) {
    const double cost = at.d.squaredNorm();
    const bool newton = i >= 2 && at.loops.degrees_of_freedom() <= max_newton_dof;
    const VectorXd step = newton ? newton_step(problem, q, at) : nearest(at.loops, at.T, at.d);
    if (!try_step(problem, q, at, limited(step, longest_step), newton)) return;
    if (!newton && at.loops.degrees_of_freedom() > max_newton_dof && cost - at.d.squaredNorm() < 1e-14 * cost) return;
    if (largest(at.gradient) < 1e-15 * problem.length()) return;
  }
}

LocalMinimum local_minimum_at(AssemblyProblem& problem, const std::vector<double>& q) {
  const Gradient at = gradient_at(problem, q);
  LocalMinimum out;
  out.degrees_of_freedom = at.loops.degrees_of_freedom();
  if (out.degrees_of_freedom == 0) return out;
  out.gradient = largest(at.gradient);
  const MatrixXd& Z = at.loops.basis();
  if (out.degrees_of_freedom > max_newton_dof) {
    const MatrixXd along = at.T * Z;
    out.least_curvature = symmetric_eigenvalues(along.transpose() * along)[0];
    return out;
  }
  out.least_curvature = symmetric_eigenvalues(reduced_hessian(problem, q, at, Z))[0];
  return out;
}

}  // namespace gelenk
