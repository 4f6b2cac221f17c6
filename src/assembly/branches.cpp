// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/branches.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include "assembly/loop_closure.h"
#include "assembly/search_positions.h"

namespace gelenk {
namespace {

// rad or m, relative to the length. Where two branches meet, closure errors of 1e-13 leave errors of 3e-7 in the
// coordinates and in the gradient of the distance.
constexpr double position_tolerance = 1e-5;
constexpr double flatness_limit = 1e-9;  // curvature relative to the weights, below which the minimum is not isolated

// The search ends after so many successful searches without a new assembly: one that has a third of the average share
// of the starts has been missed by then with a probability of about 1/1000.
int max_unproductive_searches(std::size_t branches) { return 50 + 20 * static_cast<int>(branches); }

class Collector {
 public:
  Collector(AssemblyProblem& problem, Dynamics& dynamics, const std::vector<int>& links)
      : problem_(problem), dynamics_(dynamics), links_(links) {}

  // Returns true if q is a new assembly. The default is always kept.
  bool add(const std::vector<double>& q, bool is_default) {
    Branch branch{.q = q, .distance = problem_.distance(q).norm(), .hits = 1, .is_default = is_default};
    const LocalMinimum minimum = local_minimum_at(problem_, q);
    branch.degrees_of_freedom = static_cast<int>(minimum.degrees_of_freedom);
    branch.is_not_isolated = minimum.degrees_of_freedom > 0 && std::abs(minimum.least_curvature) < flatness_limit;
    // The distance to the minimum, as predicted by Newton's method, must be negligible.
    const bool at_minimum =
        branch.is_not_isolated || minimum.degrees_of_freedom == 0 ||
        (minimum.least_curvature > 0 && minimum.gradient / minimum.least_curvature < position_tolerance / 10);
    if (!is_default && !at_minimum) return false;
    branch.poses = poses_at(q);
    const auto known = std::ranges::find_if(found_, [&](const Branch& other) { return is_same(other, branch); });
    if (known == found_.end()) {
      found_.push_back(std::move(branch));
      return true;
    }
    branch.hits = ++known->hits;
    if (!known->is_default && branch.distance < known->distance - position_tolerance) *known = std::move(branch);
    return false;
  }

  std::size_t size() const { return found_.size(); }

  std::vector<Branch> sorted_by_distance() && {
    std::ranges::sort(
        found_, [](const Branch& a, const Branch& b) { return std::tie(a.distance, a.q) < std::tie(b.distance, b.q); });
    return std::move(found_);
  }

 private:
  std::vector<Pose3> poses_at(const std::vector<double>& q) {
    dynamics_.set_position(q.data());
    dynamics_.readings().set_root_poses();
    std::vector<Pose3> out;
    for (const int link : links_) out.push_back(dynamics_.readings().link_pose(link));
    return out;
  }

  bool is_same(const Branch& a, const Branch& b) const {
    if (a.is_not_isolated && b.is_not_isolated)
      return std::abs(a.distance - b.distance) < position_tolerance * std::max(1.0, a.distance);
    if (links_.empty()) return problem_.separation(a.q, b.q) < position_tolerance * problem_.length();
    for (std::size_t i = 0; i < links_.size(); ++i) {
      if ((a.poses[i].p - b.poses[i].p).norm() > position_tolerance * problem_.length()) return false;
      if ((a.poses[i].R - b.poses[i].R).norm() > position_tolerance) return false;
    }
    return true;
  }

  AssemblyProblem& problem_;
  Dynamics& dynamics_;
  const std::vector<int>& links_;
  std::vector<Branch> found_;
};

}  // namespace

Branches find_branches(const Mechanism& mechanism, Dynamics& dynamics, const InitialGuess& tree,
                       const InitialGuess& cuts, const Search& search) {
  Branches out;
  const Assembled own = assemble(mechanism, dynamics, tree, cuts);
  AssemblyProblem problem(mechanism, dynamics, tree, cuts);
  Collector collector(problem, dynamics, search.links);
  // assemble() gives unspecified values less weight at the end than this search does.
  std::vector<double> nearest = own.q;
  minimize_distance(problem, nearest);
  collector.add(nearest, true);
  std::mt19937 random(search.seed);
  int unproductive_searches = 0;
  while (out.starts < search.max_starts && !out.settled) {
    ++out.starts;
    std::vector<double> q = random_position(problem, random);
    if (close_loops(problem, q) > assembled_gap) continue;
    ++out.closed;
    problem.unwind(q);
    minimize_distance(problem, q);
    problem.unwind(q);
    unproductive_searches = collector.add(q, false) ? 0 : unproductive_searches + 1;
    out.settled = unproductive_searches >= max_unproductive_searches(collector.size());
  }
  out.found = std::move(collector).sorted_by_distance();
  std::ranges::find_if(out.found, &Branch::is_default)->q = own.q;
  return out;
}

}  // namespace gelenk
