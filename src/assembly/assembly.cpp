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

// Guesses that are met as well as this [rad, m] have chosen among the ways to close a loop.
constexpr double met = 0.1;
// Of the mechanism's length, for each of its links: given values that leave no more of a gap than this, which is
// rounding, close the loops.
constexpr double as_given = 1e-15;
constexpr double weaker = 1e-4;
// Of the largest pivot: where the loops close to rounding, coordinates at a singular configuration are known to its
// root, about 3e-8, and pivots below that are zero. A speed divided by one would be a number without meaning.
constexpr double singular = 1e-7;
constexpr double rounding_pivot = 1e-15;  // likewise, where nothing but rounding is left
// Of the squared distance: what is not nearer by this much more than rounding is no reason to go another way.
constexpr double nearer = 1e-6;
constexpr double elsewhere = 1e-3;  // rad or m: between positions that are not the same
constexpr double bent =
    1e-6;  // of weights: bending of the distance where one place is the nearest among its neighbours
// Of mechanisms with more speeds fewer assemblies are looked at: each takes long.
constexpr int many_speeds = 30;

// The widest gap, where the loops are: m, rad and the joint.
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
    const double off = std::abs(Phi[mechanism.first_coordinate_row() + static_cast<int>(i)]);
    if (off <= std::max(assembled_gap, gap + turn)) continue;
    const bool is_angle = mechanism.coordinate_rows[i].is_angle;
    gap = is_angle ? 0 : off;
    turn = is_angle ? off : 0;
    worst = static_cast<int>(mechanism.cuts.size() + i);
  }
  gap = std::max(0.0, gap);
}

std::vector<double> close_loops(const Mechanism& mechanism, Dynamics& dynamics, AssemblyProblem& problem,
                                const InitialGuess& tree, const InitialGuess& cuts, int& tries) {
  std::vector<double> best;
  double smallest = INFINITY;
  for (tries = 1; tries <= most_attempts; ++tries) {
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

// Whether no neighbours are as near to the wishes.
bool stands_alone(AssemblyProblem& problem, const std::vector<double>& q) {
  const LocalMinimum minimum = local_minimum_at(problem, q);
  return minimum.degrees_of_freedom == 0 || minimum.least_curvature > bent;
}

// The loops are closed from where the tree is wished to be. Where that leaves a guess behind, one at a cut joint for
// instance, a loop may have closed the other way than was meant: others are looked for, beside the wishes and then
// anywhere, until many searches have found nothing nearer. The nearest is taken, which does not depend on what is cut.
// Returns another that is as near; empty: there is none.
std::vector<double> heed_guesses(AssemblyProblem& problem, const InitialGuess& tree, std::vector<double>& q) {
  constexpr std::array beside = {0, 8, 10, 12, 14, 16, 18, 20};
  std::mt19937 random(1);  // NOLINT(bugprone-random-generator-seed): the same scene gives the same start
  std::vector<double> equal;
  double least = problem.distance(q).squaredNorm();
  const int patience = static_cast<int>(tree.v.size()) <= many_speeds ? 50 : static_cast<int>(beside.size());
  for (int i = 0, in_vain = 0; in_vain < patience && problem.moved(q) > met; ++i, ++in_vain) {
    const auto k = static_cast<std::size_t>(i);
    std::vector<double> other = k < beside.size() ? perturbed(problem, tree.q, beside[k]) : problem.scattered(random);
    if (k < beside.size()) relax(problem, other);  // often to one place, wherever it starts
    if (close_loops(problem, other) > assembled_gap) continue;
    problem.unwind(other);
    minimize_distance(problem, other);
    const double distance = problem.distance(other).squaredNorm();
    if (std::abs(distance - least) <= nearer * least) {
      if (problem.apart(other, q) > elsewhere && stands_alone(problem, other)) equal = std::move(other);
      continue;
    }
    if (distance > least) continue;
    least = distance;
    q = std::move(other);
    equal.clear();
    in_vain = 0;
  }
  return equal;
}

// The wishes with all that the user gave kept exactly.
InitialGuess all_given_fixed(const InitialGuess& guesses) {
  InitialGuess out = guesses;
  for (std::size_t k = 0; k < out.q_fixed.size(); ++k) {
    if (out.q_given[k]) out.q_fixed[k] = true;
  }
  return out;
}

// The wishes with those that nobody asked for made so weak that they move nothing that was given.
InitialGuess given_first(const InitialGuess& guesses) {
  InitialGuess out = guesses;
  for (std::size_t k = 0; k < out.q_weight.size(); ++k) {
    if (!out.q_given[k]) out.q_weight[k] *= weaker;
  }
  return out;
}

// Start values that close the loops as they are given stay as they are: only coordinates that nobody gave are looked
// for. False: they do not close.
bool closes_as_given(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree, const InitialGuess& cuts,
                     std::vector<double>& q) {
  const InitialGuess fixed_tree = all_given_fixed(tree);
  const InitialGuess fixed_cuts = all_given_fixed(cuts);
  AssemblyProblem problem(mechanism, dynamics, fixed_tree, fixed_cuts);
  std::vector<double> found = tree.q;
  const double rounding = as_given * static_cast<double>(mechanism.links.size()) * problem.length();
  if (!(close_loops(problem, found) <= rounding)) return false;
  problem.unwind(found);
  minimize_distance(problem, found);
  q = std::move(found);
  return true;
}

// As near to what was given as can be. What nobody gave has helped to find a way so far; that has moved what was
// given by about its weight.
void settle_on_given(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree, const InitialGuess& cuts,
                     std::vector<double>& q) {
  const InitialGuess first_tree = given_first(tree);
  const InitialGuess first_cuts = given_first(cuts);
  AssemblyProblem problem(mechanism, dynamics, first_tree, first_cuts);
  minimize_distance(problem, q);
}

std::vector<double> consistent_speeds(const Mechanism& mechanism, Dynamics& dynamics, AssemblyProblem& problem,
                                      const InitialGuess& tree, const InitialGuess& cuts,
                                      const std::vector<double>& q) {
  AssemblyProblem::Speeds s = problem.speeds(q);
  const auto& free = problem.free(AssemblyProblem::Level::velocity);
  const auto n = static_cast<Eigen::Index>(free.size());
  double speed = 1;
  for (const double fixed : s.v) speed = std::max(speed, std::abs(fixed));
  double allowed = assembled_gap * speed * problem.length();
  const VectorXd v = nearest_speeds(s, singular);
  const VectorXd left = s.G.rows() > 0 ? VectorXd(s.G * v + s.g0) : VectorXd();
  // What a pivot that is taken for zero holds of the speeds cannot be met, nor does it mean anything.
  if (largest(left) > allowed && RowSpace(s.G, singular).rank() < RowSpace(s.G, rounding_pivot).rank()) {
    allowed += singular * speed * s.G.coeffs().cwiseAbs().maxCoeff();
  }
  if (largest(left) > allowed) {
    throw CannotAssemble(largest(left), 0, -1, q,
                         conflicting_speeds(mechanism, dynamics, tree, cuts, q, allowed, singular));
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
    out.equal_q = heed_guesses(problem, tree, out.q);
    settle_on_given(mechanism, dynamics, tree, cuts, out.q);
  }
  out.gap = largest(problem.gap(out.q)) / problem.length();
  out.moved = problem.moved(out.q);
  out.v = consistent_speeds(mechanism, dynamics, problem, tree, cuts, out.q);
  return out;
}

}  // namespace gelenk
