// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/nearest_assembly.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>

#include "assembly/assembly_problem.h"
#include "assembly/known_assemblies.h"
#include "assembly/loop_closure.h"
#include "assembly/search_positions.h"
#include "mechanism/mechanism.h"

namespace gelenk {
namespace {

// rad, m: if no coordinate changes by more, the assembly is the one that the guesses select.
constexpr double guess_tolerance = 0.1;
// Closure error per link, relative to the mechanism's length, up to which given values close the loops: rounding.
constexpr double given_gap_per_link = 1e-15;
constexpr double unspecified_weight_factor = 1e-4;  // on the weights of values that the user did not give
// Relative to the squared distance: a smaller gain, little more than rounding, is no reason to prefer an assembly.
constexpr double min_relative_gain = 1e-6;
constexpr double negligible_change = 1e-6;  // rad or m: a squared distance below its square is zero
constexpr double min_separation = 1e-3;     // rad or m, between two positions that count as different
// Curvature of the squared distance, relative to the weights, above which a minimum is isolated.
constexpr double min_curvature = 1e-6;
// For groups with more velocities fewer assemblies are tried, since each is expensive.
constexpr int max_velocities_full_search = 45;
// The search ends after so many starts that lead to nothing nearer, more for each assembly that has been found.
constexpr int min_unsuccessful = 16;
constexpr int unsuccessful_per_assembly = 8;
constexpr int max_unsuccessful = 50;
// In groups of fewer velocities starts are cheaper and more of them are made, up to this factor.
constexpr double velocities_few_starts = 40;
constexpr double max_more_starts = 4;
// Most starts close, or go astray, in fewer steps.
constexpr int max_closing_steps = 40;
// Closing gives up where the squared distance has become so many times that of the best assembly.
constexpr double astray = 6;
// Perturbations of the first starts.
constexpr std::array perturbation_levels = {0, 8, 10, 12, 14, 16, 18, 20};

// Moves to a minimum of the distance, with angles within half a turn of their guesses.
void settle(AssemblyProblem& problem, std::vector<double>& q) {
  problem.unwind(q);
  for (int i = 0; i < 4; ++i) {
    minimize_distance(problem, q);
    if (!problem.unwind(q)) return;
  }
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

// A start problem: the guesses of a group, and the largest closure error of its solutions.
struct GroupProblem {
  GroupProblem(const Mechanism& mechanism, Dynamics& dynamics, const LoopGroup& group, InitialGuess of_tree,
               InitialGuess of_cuts)
      : tree(std::move(of_tree)), cuts(std::move(of_cuts)), is(mechanism, dynamics, tree, cuts, &group.rows) {}
  GroupProblem(const GroupProblem&) = delete;
  GroupProblem& operator=(const GroupProblem&) = delete;

  InitialGuess tree, cuts;
  AssemblyProblem is;
  double max_gap = assembled_gap;
};

// Compares assemblies: those in which given values change less are nearer and, if these change equally, those in which
// the others change less. Of equal ones, the coordinates decide.
class Candidates {
 public:
  // search: the problem that is solved. final: with weights in which values that were not given do not move given ones.
  Candidates(AssemblyProblem& search, AssemblyProblem& final, std::vector<double> q)
      : search_(search), final_(final), found_{q}, best_(std::move(q)) {
    minimize_distance(final_, best_);
    least_ = final_.squared_distance(best_);
  }

  // q: at a minimum of the distance of the search. Returns whether it is nearer than all others so far.
  bool add(std::vector<double> q) {
    for (const std::vector<double>& known : found_) {
      if (search_.separation(known, q) <= min_separation) return false;
    }
    found_.push_back(q);
    minimize_distance(final_, q);
    const AssemblyProblem::Squared distance = final_.squared_distance(q);
    const int order = compare(distance, least_);
    if (order > 0) return false;
    if (order == 0) {
      if (final_.separation(q, best_) <= min_separation || !is_isolated(q)) return false;
      if (comes_first(q)) std::swap(q, best_);
      equal_ = std::move(q);
      return false;
    }
    least_ = distance;
    best_ = std::move(q);
    equal_.clear();
    return true;
  }

  // Squared distances, in the weights of the search, that a nearer assembly cannot exceed.
  AssemblyProblem::Squared bounds() const {
    if (least_.given > negligible_change * negligible_change) return {least_.given, INFINITY};
    return {0, least_.other / unspecified_weight_factor};
  }
  // Number of different assemblies found.
  int count() const { return static_cast<int>(found_.size()); }
  const std::vector<double>& best() const { return best_; }
  const std::vector<double>& equal() const { return equal_; }

 private:
  static int compare(const AssemblyProblem::Squared& a, const AssemblyProblem::Squared& b) {
    const auto order = [](double x, double y) {
      const double tolerance = min_relative_gain * std::max(x, y) + negligible_change * negligible_change;
      return std::abs(x - y) <= tolerance ? 0 : x < y ? -1 : 1;
    };
    const int given = order(a.given, b.given);
    return given != 0 ? given : order(a.other / unspecified_weight_factor, b.other / unspecified_weight_factor);
  }

  bool comes_first(const std::vector<double>& q) {
    const std::vector<double> a = final_.changes_by_rank(q);
    const std::vector<double> b = final_.changes_by_rank(best_);
    for (std::size_t k = 0; k < a.size(); ++k) {
      if (std::abs(a[k] - b[k]) > min_separation) return a[k] > b[k];
    }
    return false;
  }

  // Whether q is an isolated minimum of the distance.
  bool is_isolated(const std::vector<double>& q) {
    const LocalMinimum minimum = local_minimum_at(search_, q);
    return minimum.degrees_of_freedom == 0 || minimum.least_curvature > min_curvature;
  }

  AssemblyProblem& search_;
  AssemblyProblem& final_;
  std::vector<std::vector<double>> found_;
  std::vector<double> best_, equal_;
  AssemblyProblem::Squared least_;
};

// Closes the loops from a position near the guesses; false if that fails. Many starts lead to the same position.
bool close_near(GroupProblem& problem, int perturbation, std::vector<double>& q) {
  q = perturbed(problem.is, problem.tree.q, perturbation);
  relax(problem.is, q);
  return close_loops(problem.is, q) <= problem.max_gap;
}

// Closes the loops from a random position within the bounds that a nearer assembly obeys; false if that fails, or where
// it would lead farther away. pulled: toward the guesses first. What remains of closure errors and distances then is no
// more than the distance of any assembly in the neighborhood.
bool close_within(GroupProblem& problem, const AssemblyProblem::Squared& bounds, bool pulled, std::mt19937& random,
                  std::vector<double>& q) {
  q = random_position(problem.is, random, bounds);
  if (pulled) {
    const double left = relax(problem.is, q);
    const bool others_count = std::isfinite(bounds.other);
    const double others = others_count ? 0 : problem.is.squared_tree_distance(q).other;
    if (left - others > (others_count ? bounds.other : bounds.given)) return false;
  }
  const ClosingLimits limits{
      .steps = max_closing_steps,
      .within = {astray * std::max(bounds.given, guess_tolerance * guess_tolerance), astray * bounds.other}};
  return close_loops(problem.is, q, limits) <= problem.max_gap;
}

// The loops have closed from the guesses of the tree joints, perhaps in an assembly far from the guesses. Others are
// searched for, first near the guesses and then from random positions where a nearer one may be, until many searches in
// a row find nothing nearer. The nearest one depends neither on where the loops are cut nor on the order of the file.
void search_nearest(const LoopGroup& group, GroupProblem& problem, Candidates& candidates) {
  std::mt19937 random(1);  // NOLINT(bugprone-random-generator-seed): the same scene gives the same start
  const auto limit = [&] {
    if (group.size > max_velocities_full_search) return static_cast<int>(perturbation_levels.size());
    const double more = std::clamp(velocities_few_starts / group.size, 1.0, max_more_starts);
    return static_cast<int>(
        more * std::min(max_unsuccessful, min_unsuccessful + unsuccessful_per_assembly * candidates.count()));
  };
  std::vector<double> other;
  for (int i = 0, unsuccessful = 0; unsuccessful < limit() && problem.is.moved(candidates.best()).any > guess_tolerance;
       ++i, ++unsuccessful) {
    const auto k = static_cast<std::size_t>(i);
    const bool closed = k < perturbation_levels.size()
                            ? close_near(problem, perturbation_levels[k], other)
                            : close_within(problem, candidates.bounds(), i % 2 == 0, random, other);
    if (!closed) continue;
    settle(problem.is, other);
    if (candidates.add(other)) unsuccessful = 0;
  }
}

// Closes the loops from perturbed guesses until one attempt succeeds; otherwise q is the best attempt.
bool close_from_guesses(AssemblyProblem& problem, const std::vector<double>& guess, std::vector<double>& q,
                        int& tries) {
  double smallest = INFINITY;
  for (tries = 1; tries <= max_attempts; ++tries) {
    std::vector<double> at = perturbed(problem, guess, tries - 1);
    const double gap = close_loops(problem, at);
    const bool closed = gap <= assembled_gap;
    if (closed || gap < smallest || tries == 1) {
      smallest = gap;
      q = std::move(at);
    }
    if (closed) break;
  }
  problem.unwind(q);
  return tries <= max_attempts;
}

}  // namespace

NearestAssembly close_nearest(const Mechanism& mechanism, Dynamics& dynamics, const LoopGroup& group,
                              const InitialGuess& tree, const InitialGuess& cuts, std::vector<double>& q) {
  NearestAssembly out;
  const double weight = largest_weight(group, tree, cuts);
  InitialGuess own_tree = guesses_of(tree, group.velocities, weight, true);
  own_tree.q = q;
  const InitialGuess own_cuts = guesses_of(cuts, group.cut_velocities, weight, false);
  std::optional<GroupProblem> problem;
  problem.emplace(mechanism, dynamics, group, fix_given_values(own_tree), fix_given_values(own_cuts));
  const double rounding = given_gap_per_link * static_cast<double>(mechanism.links.size()) * problem->is.length();
  problem->max_gap = closure_tolerance * problem->is.length();
  out.closed = close_loops(problem->is, q) <= rounding;
  if (!out.closed) {
    problem.emplace(mechanism, dynamics, group, own_tree, own_cuts);
    out.closed = close_from_guesses(problem->is, own_tree.q, q, out.tries);
    if (!out.closed) return out;
  }
  settle(problem->is, q);
  GroupProblem final(mechanism, dynamics, group, downweight_unspecified(problem->tree),
                     downweight_unspecified(problem->cuts));
  Candidates candidates(problem->is, final.is, q);
  if (!(problem->is.moved(candidates.best()).any > guess_tolerance)) {
    q = candidates.best();
    return out;
  }
  AssemblyKey key(problem->is, problem->tree, problem->cuts, q);
  std::optional<KnownAssembly> nearest = find_known(key);
  if (!nearest) {
    search_nearest(group, *problem, candidates);
    nearest = KnownAssembly{candidates.best(), candidates.equal()};
    remember(std::move(key), *nearest);
  }
  q = std::move(nearest->q);
  out.equal_q = std::move(nearest->equal_q);
  return out;
}

}  // namespace gelenk
