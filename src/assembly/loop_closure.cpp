// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/loop_closure.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "linear/descent.h"

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Level = AssemblyProblem::Level;

constexpr double rounding = 2e-16;      // relative to the mechanism's length
constexpr double longest_step = 0.4;    // rad or m: farther than this the linearized loops say little
constexpr double difference = 1e-5;     // of second derivatives: as much lost by rounding as by its length
constexpr Eigen::Index most_bent = 30;  // freedoms for which second derivatives are worth their price

// The shortest steps that take residuals of the rows G away.
auto shortest_steps(const SparseMatrix& G) {
  const double scale = G.nonZeros() > 0 ? G.squaredNorm() / static_cast<double>(G.rows()) : 0;
  return [G, scale](const VectorXd& r, double damping) -> VectorXd {
    if (damping == 0 || G.cols() == 0) return -RowSpace(G).min_norm(r);
    const SparseMatrix normal = G * G.transpose();
    return -G.transpose() * solve_definite(plus_diagonal(normal, damping * scale), r);
  };
}

// Half the squared distance along the loops closed at q.
struct Gradient {
  explicit Gradient(const SparseMatrix& G) : loops(G) {}
  RowSpace loops;
  VectorXd d;         // distances
  SparseMatrix T;     // their derivative
  VectorXd whole;     // the gradient as if there were no loops
  VectorXd gradient;  // what of it the loops let through: along their basis, or where that is too wide, as it is
};

Gradient gradient_at(AssemblyProblem& problem, const std::vector<double>& q) {
  Gradient out(problem.gap_jacobian(q));
  if (out.loops.degrees_of_freedom() == 0) return out;
  out.d = problem.distance(q);
  out.T = problem.distance_jacobian(q);
  out.whole = out.T.transpose() * out.d;
  out.gradient = out.loops.has_basis() ? out.loops.basis().transpose() * out.whole : out.loops.free_part(out.whole);
  return out;
}

// Z^T (second derivatives of the Lagrangian) Z, Z the basis, by differences of its gradient.
MatrixXd reduced_hessian(AssemblyProblem& problem, const std::vector<double>& q, const Gradient& at,
                         const MatrixXd& Z) {
  VectorXd lambda;  // holds what of the gradient the loops do not let through
  if (at.loops.rows().rows() > 0) lambda = at.loops.multipliers(-at.whole);
  const auto gradient = [&](const VectorXd& step) {
    const std::vector<double> beside = problem.displaced(q, step);
    VectorXd out = problem.distance_jacobian(beside).transpose() * problem.distance(beside);
    if (lambda.size() > 0) out += problem.gap_jacobian(beside).transpose() * lambda;
    return out;
  };
  const double h = difference * problem.length();
  MatrixXd H(Z.cols(), Z.cols());
  for (Eigen::Index k = 0; k < H.cols(); ++k) {
    const VectorXd z = h * Z.col(k);
    H.col(k) = Z.transpose() * (gradient(z) - gradient(-z)) / (2 * h);
  }
  return (H + H.transpose()) / 2;
}

// Downhill, and the shortest way where the distance is bowl-shaped.
VectorXd newton_step(AssemblyProblem& problem, const std::vector<double>& q, const Gradient& at) {
  const MatrixXd& Z = at.loops.basis();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> parts(reduced_hessian(problem, q, at, Z));
  const VectorXd& bends = parts.eigenvalues();
  const double least = 1e-9 * bends.cwiseAbs().maxCoeff();
  VectorXd along = parts.eigenvectors().transpose() * at.gradient;
  for (Eigen::Index k = 0; k < along.size(); ++k) along[k] /= std::max({std::abs(bends[k]), least, 1e-300});
  return -(Z * (parts.eigenvectors() * along));
}

// One step of minimize_distance, shortened until it leads nearer; false when none does.
bool nearer(AssemblyProblem& problem, std::vector<double>& q, Gradient& at, VectorXd step, bool newton) {
  const double cost = at.d.squaredNorm();
  for (int k = 0; k < 8; ++k, step /= 4) {
    if (largest(step) < 1e-13 * problem.length()) return false;
    std::vector<double> next = problem.displaced(q, step);
    if (!(close_loops(problem, next) <= assembled_gap)) continue;  // nor where it is no number
    const double next_cost = problem.distance(next).squaredNorm();
    // Near the bottom the distance is level within rounding; its slope still tells.
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

VectorXd nearest_speeds(const AssemblyProblem::Speeds& s, double threshold) {
  const RowSpace loops(s.G, threshold);
  const VectorXd v = -loops.min_norm(s.g0);
  return loops.degrees_of_freedom() > 0 ? VectorXd(v + nearest(loops, s.T, s.T * v + s.d0)) : v;
}

double close_loops(AssemblyProblem& problem, std::vector<double>& q) {
  // Beside a singular configuration a gap of 1e-13 leaves 3e-7 of a coordinate open, so what is closed is closed
  // further as long as that makes progress; there Newton's method quarters the gap at each step.
  const Descent how{.tolerance = closure_tolerance * problem.length(),
                    .rounding = rounding * problem.length(),
                    .longest_step = longest_step,
                    .most_steps = 200};
  return largest(descend(
      q, how, [&](const auto& at) { return problem.gap(at); },
      [&](const auto& at) { return shortest_steps(problem.gap_jacobian(at)); },
      [&](const auto& at, const VectorXd& step) { return problem.displaced(at, step); }));
}

bool close_rows(const Mechanism& mechanism, Dynamics& dynamics, std::vector<double>& q) {
  double length = 1;
  for (const Link& link : mechanism.links) length += link.X_PJ.p.norm();
  const Descent how{.tolerance = closure_tolerance * length,
                    .least_damping = 1e-10,  // pivots below its root are those of rows that repeat others
                    .longest_step = longest_step,
                    .most_steps = 60};
  const auto residual = [&](const auto& at) {
    dynamics.set_position(at.data());
    return VectorXd(Eigen::Map<const VectorXd>(dynamics.Phi().data(), mechanism.rows));
  };
  const auto linearized = [&](const auto& at) {
    dynamics.set_position(at.data());
    return shortest_steps(dynamics.sparse_J());
  };
  const auto displaced = [&](auto at, const VectorXd& step) {
    dynamics.displace(at.data(), step.data());
    return at;
  };
  return largest(descend(q, how, residual, linearized, displaced)) <= how.tolerance;
}

void relax(AssemblyProblem& problem, std::vector<double>& q) {
  const auto residual = [&](const auto& at) {
    const VectorXd g = problem.gap(at);
    const VectorXd d = problem.distance(at);
    return VectorXd((VectorXd(g.size() + d.size()) << g, d).finished());
  };
  const auto linearized = [&](const auto& at) {
    return [G = problem.gap_jacobian(at), T = problem.distance_jacobian(at)](const VectorXd& r,
                                                                             double damping) -> VectorXd {
      if (G.cols() == 0) return {};
      const SparseMatrix normal = G.transpose() * G + SparseMatrix(T.transpose() * T);
      const VectorXd downhill = G.transpose() * r.head(G.rows()) + T.transpose() * r.tail(T.rows());
      return -solve_definite(plus_diagonal(normal, damping), downhill);
    };
  };
  // A rough way: to within what the last steps take away, and by coordinates that neither loops nor wishes tell of no
  // farther than need be.
  descend(q, {.least_progress = 1e-4, .least_damping = 1e-4, .longest_step = longest_step, .most_steps = 40}, residual,
          linearized, [&](const auto& at, const VectorXd& step) { return problem.displaced(at, step); });
}

void minimize_distance(AssemblyProblem& problem, std::vector<double>& q) {
  Gradient at = gradient_at(problem, q);
  for (int i = 0; i < 100 && at.loops.degrees_of_freedom() > 0; ++i) {
    const double cost = at.d.squaredNorm();
    const bool newton = i >= 2 && at.loops.degrees_of_freedom() <= most_bent;
    const VectorXd step = newton ? newton_step(problem, q, at) : nearest(at.loops, at.T, at.d);
    if (!nearer(problem, q, at, limited(step, longest_step), newton)) return;
    if (!newton && at.loops.degrees_of_freedom() > most_bent && cost - at.d.squaredNorm() < 1e-14 * cost) return;
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
  if (out.degrees_of_freedom > most_bent) {
    const MatrixXd along = at.T * Z;
    out.least_curvature = (along.transpose() * along).selfadjointView<Eigen::Lower>().eigenvalues()[0];
    return out;
  }
  out.least_curvature = Eigen::SelfAdjointEigenSolver<MatrixXd>(reduced_hessian(problem, q, at, Z)).eigenvalues()[0];
  return out;
}

std::vector<double> perturbed(const AssemblyProblem& problem, const std::vector<double>& q, int attempt) {
  if (attempt == 0) return q;
  std::mt19937 random(static_cast<unsigned>(attempt));
  // At first small, for guesses that stand on a dead point; in the end anywhere.
  const double reach = std::min(std::numbers::pi, 0.05 * std::pow(1.35, attempt));
  std::uniform_real_distribution<double> shake(-reach, reach);
  const auto n = static_cast<Eigen::Index>(problem.free(Level::position).size());
  VectorXd step(n);
  for (Eigen::Index k = 0; k < n; ++k) step[k] = shake(random) * problem.length();
  return problem.displaced(q, step);
}

}  // namespace gelenk
