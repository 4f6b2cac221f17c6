// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/assembly.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "analysis/assembly_problem.h"
#include "analysis/closing.h"
#include "analysis/conflict.h"
#include "scene/text.h"

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Guesses that are met as well as this [rad, m] have chosen among the ways to close a loop.
constexpr double met = 0.1;
// Of the squared distance: what is not nearer by this much more than rounding is no reason to go another way.
constexpr double nearer = 0.99;

double largest(const VectorXd& x) { return x.size() == 0 ? 0 : x.lpNorm<Eigen::Infinity>(); }

std::string gap_text(const Mechanism& mechanism, const Dynamics& dynamics, int& worst) {
  double gap = -1;
  double turn = 0;
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
  const std::string metres = text::rounded(std::max(0.0, gap), 3) + " m";
  return turn > assembled_gap ? metres + " and " + text::rounded(turn, 3) + " rad" : metres;
}

std::vector<double> close_loops(const Mechanism& mechanism, Dynamics& dynamics, AssemblyProblem& problem,
                                const Wishes& tree, const Wishes& cuts, int& tries) {
  std::vector<double> best;
  double smallest = INFINITY;
  for (tries = 1; tries <= most_attempts; ++tries) {
    std::vector<double> q = shaken(problem, tree.q, tries - 1);
    const double gap = close_gaps(problem, q);
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
  const std::string gap = gap_text(mechanism, dynamics, worst);
  throw CannotAssemble(gap, worst, best, conflicting_positions(mechanism, dynamics, tree, cuts, best));
}

// The loops are closed from where the tree is wished to be. Where that leaves a guess behind, one at a cut joint for
// instance, a loop may have closed the other way than was meant: others are looked for, and the nearest is taken.
void heed_guesses(AssemblyProblem& problem, const Wishes& tree, std::vector<double>& q) {
  double least = problem.distance(q).squaredNorm();
  for (const int attempt : {0, 8, 10, 12, 14, 16, 18, 20}) {
    if (problem.moved(q) <= met) return;
    std::vector<double> other = shaken(problem, tree.q, attempt);
    pull(problem, other);
    if (close_gaps(problem, other) > assembled_gap) continue;
    problem.unwind(other);
    come_near(problem, other);
    const double distance = problem.distance(other).squaredNorm();
    if (distance >= nearer * least) continue;
    least = distance;
    q = std::move(other);
  }
}

std::vector<double> consistent_speeds(const Mechanism& mechanism, Dynamics& dynamics, AssemblyProblem& problem,
                                      const Wishes& tree, const Wishes& cuts, const std::vector<double>& q) {
  AssemblyProblem::Speeds s = problem.speeds(q);
  const auto& free = problem.free(AssemblyProblem::Level::velocity);
  const auto n = static_cast<Eigen::Index>(free.size());
  VectorXd v = VectorXd::Zero(n);
  if (s.G.rows() > 0 && n > 0) v = -s.G.completeOrthogonalDecomposition().solve(s.g0);
  const VectorXd left = s.G.rows() > 0 ? VectorXd(s.G * v + s.g0) : VectorXd();
  double speed = 1;
  for (const double fixed : s.v) speed = std::max(speed, std::abs(fixed));
  const double allowed = assembled_gap * speed * problem.length();
  if (largest(left) > allowed) {
    throw CannotAssemble(text::rounded(largest(left), 3), -1, q,
                         conflicting_speeds(mechanism, dynamics, tree, cuts, q, allowed));
  }
  const MatrixXd Z = nullspace(s.G, n);
  if (Z.cols() > 0) {
    const VectorXd d = s.T * v + s.d0;
    v -= Z * (s.T * Z).completeOrthogonalDecomposition().solve(d);
  }
  for (Eigen::Index k = 0; k < n; ++k) s.v[free[static_cast<std::size_t>(k)]] = v[k];
  return s.v;
}

}  // namespace

Assembled assemble(const Mechanism& mechanism, Dynamics& dynamics, const Wishes& tree, const Wishes& cuts) {
  Assembled out;
  if (mechanism.rows == 0 && mechanism.cuts.empty()) {
    out.q = tree.q;
    out.v = tree.v;
    return out;
  }
  AssemblyProblem problem(mechanism, dynamics, tree, cuts);
  out.q = close_loops(mechanism, dynamics, problem, tree, cuts, out.tries);
  come_near(problem, out.q);
  heed_guesses(problem, tree, out.q);
  out.moved = problem.moved(out.q);
  out.v = consistent_speeds(mechanism, dynamics, problem, tree, cuts, out.q);
  return out;
}

}  // namespace gelenk
