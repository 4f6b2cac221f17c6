// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/conflict.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "assembly/loop_closure.h"
#include "assembly/search_positions.h"
#include "decomposition/dense.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t max_fixed_values = 40;  // beyond this the search would be too expensive

// Appends the fixed coordinates of a joint with nq coordinates from iq on and nv velocities from iv on.
void list_fixed(const InitialGuess& guesses, bool cut, int iq, int nq, int iv, int nv, std::vector<FixedValue>& out) {
  const int plain = nq > nv ? nq - 4 : nq;  // the rest is a quaternion
  for (int i = 0; i < std::min(plain, nv); ++i) {
    if (guesses.q_fixed[iv + i]) out.push_back({.cut = cut, .first = iv + i, .count = 1, .q = iq + i});
  }
  if (nq > nv && guesses.q_fixed[iv + plain]) {
    out.push_back({.cut = cut, .first = iv + plain, .count = 3, .q = iq + plain});
  }
}

std::vector<FixedValue> fixed_positions(const Mechanism& mechanism, const InitialGuess& tree,
                                        const InitialGuess& cuts) {
  std::vector<FixedValue> out;
  for (const Link& link : mechanism.links) {
    if (link.parent >= 0) list_fixed(tree, false, link.iq, link.nq, link.iv, link.nv, out);
  }
  for (const Cut& cut : mechanism.cuts) {
    if (!cut.is_rod()) list_fixed(cuts, true, cut.iq, cut.nq, cut.iv, cut.nv, out);
  }
  return out;
}

std::vector<FixedValue> without(const std::vector<FixedValue>& all, std::size_t i) {
  std::vector<FixedValue> out = all;
  out.erase(out.begin() + static_cast<std::ptrdiff_t>(i));
  return out;
}

// Removes values one by one as long as the others are inconsistent: the rest is an irreducible inconsistent set.
void reduce_to_core(std::vector<FixedValue>& values,
                    const std::function<bool(const std::vector<FixedValue>&)>& is_consistent) {
  for (std::size_t i = 0; i < values.size();) {
    const std::vector<FixedValue> fewer = without(values, i);
    if (is_consistent(fewer)) {
      ++i;
    } else {
      values = fewer;
    }
  }
}

struct ConflictSearch {
  const Mechanism& mechanism;
  Dynamics& dynamics;
  const InitialGuess& tree;
  const InitialGuess& cuts;
  const std::vector<double>& q;
  InitialGuess some_tree{}, some_cuts{};  // with only some of the values fixed

  void fix(const std::vector<FixedValue>& values) {
    some_tree = tree;
    some_cuts = cuts;
    some_tree.q_fixed.assign(tree.q_fixed.size(), false);
    some_cuts.q_fixed.assign(cuts.q_fixed.size(), false);
    for (const FixedValue& value : values) {
      std::vector<bool>& flags = (value.cut ? some_cuts : some_tree).q_fixed;
      std::fill_n(flags.begin() + value.first, value.count, true);
    }
  }

  // Closes the loops with these values fixed, as near to the other guesses as a few searches find; empty: none
  // succeeded.
  std::optional<std::vector<double>> search(const std::vector<FixedValue>& values) {
    fix(values);
    AssemblyProblem problem(mechanism, dynamics, some_tree, some_cuts);
    for (const int attempt : {0, -1, 4, 8, 12, 16, 20, 24}) {
      std::vector<double> at = attempt < 0 ? q : perturbed(problem, tree.q, attempt);
      if (close_loops(problem, at) > assembled_gap) continue;
      problem.unwind(at);
      minimize_distance(problem, at);
      return at;
    }
    return std::nullopt;
  }

  double coordinate(const FixedValue& value, const std::vector<double>& at) {
    if (!value.cut) return at[value.q];
    dynamics.set_position(at.data());
    const auto holds = [&](const Cut& cut) { return cut.iq <= value.q && value.q < cut.iq + cut.nq; };
    const auto cut = std::ranges::find_if(mechanism.cuts, holds);
    double found[max_cut_nq];
    std::copy_n(cuts.q.data() + cut->iq, cut->nq, found);
    dynamics.cut_coordinates(static_cast<int>(cut - mechanism.cuts.begin()), found);
    const double x = found[value.q - cut->iq];
    if (!cut->is_angle[value.q - cut->iq]) return x;
    return x + 2 * std::numbers::pi * std::round((cuts.q[value.q] - x) / (2 * std::numbers::pi));
  }
};

}  // namespace

Conflict conflicting_positions(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree,
                               const InitialGuess& cuts, const std::vector<double>& q) {
  const std::vector<FixedValue> all = fixed_positions(mechanism, tree, cuts);
  ConflictSearch searcher{.mechanism = mechanism, .dynamics = dynamics, .tree = tree, .cuts = cuts, .q = q};
  Conflict out;
  if (all.empty() || all.size() > max_fixed_values || !searcher.search({})) return out;
  out.values = all;
  reduce_to_core(out.values,
                 [&](const std::vector<FixedValue>& values) { return searcher.search(values).has_value(); });
  double least = INFINITY;
  for (std::size_t i = 0; i < out.values.size(); ++i) {
    const FixedValue& value = out.values[i];
    if (value.count > 1) continue;
    const auto same = [&](const FixedValue& other) { return other.cut == value.cut && other.first == value.first; };
    const auto place = std::ranges::find_if(all, same) - all.begin();
    const auto at = searcher.search(without(all, static_cast<std::size_t>(place)));
    if (!at) continue;
    const double nearest = searcher.coordinate(value, *at);
    const double change = std::abs(nearest - (value.cut ? cuts : tree).q[value.q]);
    if (change >= least) continue;
    least = change;
    out.freed = static_cast<int>(i);
    out.nearest = nearest;
  }
  return out;
}

Conflict conflicting_velocities(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree,
                                const InitialGuess& cuts, const std::vector<double>& q, double tolerance,
                                double singular) {
  std::vector<FixedValue> values;
  for (const bool cut : {false, true}) {
    const std::vector<bool>& flags = (cut ? cuts : tree).v_fixed;
    for (int k = 0; k < static_cast<int>(flags.size()); ++k) {
      if (flags[k]) values.push_back({.cut = cut, .first = k, .count = 1, .q = -1});
    }
  }
  // With nothing fixed and all weights 1 the rows of T give the velocities themselves, and d0 their distances at rest.
  InitialGuess plain[] = {tree, cuts};
  for (InitialGuess& guesses : plain) {
    guesses.v_fixed.assign(guesses.v_fixed.size(), false);
    guesses.v_weight.assign(guesses.v_weight.size(), 1);
  }
  AssemblyProblem problem(mechanism, dynamics, plain[0], plain[1]);
  const AssemblyProblem::VelocityEquations s = problem.velocity_equations(q);
  const MatrixXd G = s.G;
  const Eigen::SparseMatrix<double, Eigen::RowMajor> T = s.T;
  const auto row = [&](const FixedValue& value) { return value.first + (value.cut ? mechanism.nv : 0); };
  const auto solve = [&](const std::vector<FixedValue>& fixed, double& left) {
    const Eigen::Index rows = G.rows();
    MatrixXd A(rows + static_cast<Eigen::Index>(fixed.size()), G.cols());
    VectorXd b(A.rows());
    A.topRows(rows) = G;
    b.head(rows) = -s.g0;
    for (std::size_t i = 0; i < fixed.size(); ++i) {
      A.row(rows + static_cast<Eigen::Index>(i)) = MatrixXd(T.row(row(fixed[i])));
      b[rows + static_cast<Eigen::Index>(i)] = -s.d0[row(fixed[i])];
    }
    const VectorXd v = least_norm_solution(A, b, singular);
    left = (A * v - b).lpNorm<Eigen::Infinity>();
    return v;
  };
  const std::vector<FixedValue> all = values;
  double left = 0;
  reduce_to_core(values, [&](const std::vector<FixedValue>& fixed) { return solve(fixed, left), left <= tolerance; });
  Conflict out{.values = values, .freed = -1, .nearest = 0};
  double least = INFINITY;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const FixedValue& value = values[i];
    const auto same = [&](const FixedValue& other) { return other.cut == value.cut && other.first == value.first; };
    const VectorXd v =
        solve(without(all, static_cast<std::size_t>(std::ranges::find_if(all, same) - all.begin())), left);
    const double found = T.row(row(value)).dot(v);
    const double change = std::abs(found - (value.cut ? cuts : tree).v[value.first]);
    if (left > tolerance || change >= least) continue;
    least = change;
    out.freed = static_cast<int>(i);
    out.nearest = found;
  }
  return out;
}

}  // namespace gelenk
