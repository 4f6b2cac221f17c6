// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/assembly.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "assembly/assembly_problem.h"
#include "assembly/conflict.h"
#include "assembly/loop_closure.h"
#include "linear/descent.h"

namespace gelenk {
namespace {

using Eigen::VectorXd;

// rad, m: if all guesses are satisfied this well, the assembly is the one that they select.
constexpr double guess_tolerance = 0.1;
// Closure error per link, relative to the mechanism's length, up to which given values close the loops: rounding.
constexpr double given_gap_per_link = 1e-15;
constexpr double unspecified_weight_factor = 1e-4;  // on the weights of values that the user did not give
// Relative to the largest pivot. If the loops close to rounding, coordinates at a singular configuration are known to
// its square root only, about 3e-8, and smaller pivots are zero. A velocity divided by one would be meaningless.
constexpr double singular_pivot_ratio = 1e-7;
constexpr double rounding_pivot_ratio = 1e-15;  // relative to the largest pivot: rounding
// Relative to the squared distance: a smaller gain, little more than rounding, is no reason to prefer an assembly.
constexpr double min_relative_gain = 1e-6;
constexpr double min_separation = 1e-3;  // rad or m, between two positions that count as different
// Curvature of the squared distance, relative to the weights, above which a minimum is isolated.
constexpr double min_curvature = 1e-6;
// For mechanisms with more velocities fewer assemblies are tried, since each is expensive.
constexpr int max_velocities_full_search = 30;

// Finds the joint with the largest closure error at the present position: gap [m], turn [rad], its index in worst.
void find_gap(const Mechanism& mechanism, const Dynamics& dynamics, double& gap, double& turn, int& worst) {
  gap = -1;
  turn = 0;
  const auto& Phi = dynamics.Phi();
  for (int c = 0; c < static_cast<int>(mechanism.cuts.size()); ++c) {
    const Cut& cut = mechanism.cuts[c];
    double sum = 0;
    double angle = 0;
    for (int r = cut.first_row; r < cut.first_row + cut.rows; ++r) {
      (dynamics.row_is_angle(r) ? angle : sum) += Phi[r] * Phi[r];
    }
    if (std::sqrt(sum) + std::sqrt(angle) <= gap + turn) continue;
    gap = std::sqrt(sum);
    turn = std::sqrt(angle);
    worst = c;
  }
  for (std::size_t i = 0; i < mechanism.coordinate_rows.size(); ++i) {
    const double error = std::abs(Phi[mechanism.first_coordinate_row() + static_cast<int>(i)]);
    if (error <= std::max(assembled_gap, gap + turn)) continue;
    const bool is_angle = mechanism.coordinate_rows[i].is_angle;
    gap = is_angle ? 0 : error;
    turn = is_angle ? error : 0;
    worst = static_cast<int>(mechanism.cuts.size() + i);
  }
  gap = std::max(0.0, gap);
}

std::vector<double> close_loops(const Mechanism& mechanism, Dynamics& dynamics, AssemblyProblem& problem,
                                const InitialGuess& tree, const InitialGuess& cuts, int& tries) {
  std::vector<double> best;
  double smallest = INFINITY;
  for (tries = 1; tries <= max_attempts; ++tries) {
    std::vector<double> q = perturbed(problem, tree.q, tries - 1);
    const double gap = close_loops(problem, q);
    if (gap <= assembled_gap) {
      problem.unwind(q);
      return q;
    }
    if (best.empty() || gap < smallest) {
      best = q;
      smallest = gap;
    }
  }
  problem.unwind(best);
  problem.gap(best);
  int worst = 0;
  double gap = 0;
  double turn = 0;
  find_gap(mechanism, dynamics, gap, turn, worst);
  throw CannotAssemble(gap, turn, worst, best, conflicting_positions(mechanism, dynamics, tree, cuts, best));
}

// Whether q is an isolated minimum of the distance.
bool is_isolated(AssemblyProblem& problem, const std::vector<double>& q) {
  const LocalMinimum minimum = local_minimum_at(problem, q);
  return minimum.degrees_of_freedom == 0 || minimum.least_curvature > min_curvature;
}

// The loops are closed starting from the guesses of the tree joints. If that leaves another guess unsatisfied, for
// example one at a cut joint, a loop may have closed in an unintended assembly. Others are then searched for, first
// near the guesses and then from random positions, until many searches in a row find nothing nearer. The nearest one is
// kept in q; it does not depend on which joints are cut.
// Returns another assembly that is as near; empty if there is none.
std::vector<double> search_nearer_assemblies(AssemblyProblem& problem, const InitialGuess& tree,
                                             std::vector<double>& q) {
  constexpr std::array perturbation_levels = {0, 8, 10, 12, 14, 16, 18, 20};
  std::mt19937 random(1);  // NOLINT(bugprone-random-generator-seed): the same scene gives the same start
  std::vector<double> equal;
  double least = problem.distance(q).squaredNorm();
  const int max_unsuccessful =
      static_cast<int>(tree.v.size()) <= max_velocities_full_search ? 50 : static_cast<int>(perturbation_levels.size());
  for (int i = 0, unsuccessful = 0; unsuccessful < max_unsuccessful && problem.moved(q) > guess_tolerance;
       ++i, ++unsuccessful) {
    const auto k = static_cast<std::size_t>(i);
    std::vector<double> other = k < perturbation_levels.size() ? perturbed(problem, tree.q, perturbation_levels[k])
                                                               : problem.random_position(random);
    if (k < perturbation_levels.size()) relax(problem, other);  // many starts lead to the same position
    if (close_loops(problem, other) > assembled_gap) continue;
    problem.unwind(other);
    minimize_distance(problem, other);
    const double distance = problem.distance(other).squaredNorm();
    if (std::abs(distance - least) <= min_relative_gain * least) {
      if (problem.separation(other, q) > min_separation && is_isolated(problem, other)) equal = std::move(other);
      continue;
    }
    if (distance > least) continue;
    least = distance;
    q = std::move(other);
    equal.clear();
    unsuccessful = 0;
  }
  return equal;
}

// The guesses with all values given by the user fixed.
InitialGuess fix_given_values(const InitialGuess& guesses) {
  InitialGuess out = guesses;
  for (std::size_t k = 0; k < out.q_fixed.size(); ++k) {
    if (out.q_given[k]) out.q_fixed[k] = true;
  }
  return out;
}

// The guesses with the unspecified ones so weak that they do not move given values.
InitialGuess downweight_unspecified(const InitialGuess& guesses) {
  InitialGuess out = guesses;
  for (std::size_t k = 0; k < out.q_weight.size(); ++k) {
    if (!out.q_given[k]) out.q_weight[k] *= unspecified_weight_factor;
  }
  return out;
}

// Start values that already close the loops are kept: only coordinates that the user did not give are solved for.
// Returns false if the loops do not close that way.
bool closes_as_given(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree, const InitialGuess& cuts,
                     std::vector<double>& q) {
  const InitialGuess fixed_tree = fix_given_values(tree);
  const InitialGuess fixed_cuts = fix_given_values(cuts);
  AssemblyProblem problem(mechanism, dynamics, fixed_tree, fixed_cuts);
  std::vector<double> found = tree.q;
  const double rounding = given_gap_per_link * static_cast<double>(mechanism.links.size()) * problem.length();
  if (!(close_loops(problem, found) <= rounding)) return false;
  problem.unwind(found);
  minimize_distance(problem, found);
  q = std::move(found);
  return true;
}

// Minimizes the distance from the given values. So far unspecified values have guided the search, and have moved given
// ones by about their weight.
void minimize_given_distance(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree,
                             const InitialGuess& cuts, std::vector<double>& q) {
  const InitialGuess first_tree = downweight_unspecified(tree);
  const InitialGuess first_cuts = downweight_unspecified(cuts);
  AssemblyProblem problem(mechanism, dynamics, first_tree, first_cuts);
  minimize_distance(problem, q);
}

std::vector<double> consistent_velocities(const Mechanism& mechanism, Dynamics& dynamics, AssemblyProblem& problem,
                                          const InitialGuess& tree, const InitialGuess& cuts,
                                          const std::vector<double>& q) {
  AssemblyProblem::VelocityEquations s = problem.velocity_equations(q);
  const auto& free = problem.free(AssemblyProblem::Level::velocity);
  const auto n = static_cast<Eigen::Index>(free.size());
  double speed = 1;
  for (const double fixed : s.v) speed = std::max(speed, std::abs(fixed));
  double allowed = assembled_gap * speed * problem.length();
  const VectorXd v = nearest_velocities(s, singular_pivot_ratio);
  const VectorXd left = s.G.rows() > 0 ? VectorXd(s.G * v + s.g0) : VectorXd();
  // The part of the velocities that belongs to a pivot treated as zero cannot be satisfied and is meaningless.
  if (largest(left) > allowed &&
      RowSpace(s.G, singular_pivot_ratio).rank() < RowSpace(s.G, rounding_pivot_ratio).rank()) {
    allowed += singular_pivot_ratio * speed * s.G.coeffs().cwiseAbs().maxCoeff();
  }
  if (largest(left) > allowed) {
    throw CannotAssemble(largest(left), 0, -1, q,
                         conflicting_velocities(mechanism, dynamics, tree, cuts, q, allowed, singular_pivot_ratio));
  }
  for (Eigen::Index k = 0; k < n; ++k) s.v[free[static_cast<std::size_t>(k)]] = v[k];
  return s.v;
}

}  // namespace

Assembled assemble(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree, const InitialGuess& cuts) {
  Assembled out;
  if (mechanism.rows == 0 && mechanism.cuts.empty()) {
    out.q = tree.q;
    out.v = tree.v;
    return out;
  }
  AssemblyProblem problem(mechanism, dynamics, tree, cuts);
  if (!closes_as_given(mechanism, dynamics, tree, cuts, out.q)) {
    out.q = close_loops(mechanism, dynamics, problem, tree, cuts, out.tries);
    minimize_distance(problem, out.q);
    out.equal_q = search_nearer_assemblies(problem, tree, out.q);
    minimize_given_distance(mechanism, dynamics, tree, cuts, out.q);
  }
  out.gap = largest(problem.gap(out.q)) / problem.length();
  out.moved = problem.moved(out.q);
  out.v = consistent_velocities(mechanism, dynamics, problem, tree, cuts, out.q);
  return out;
}

}  // namespace gelenk
