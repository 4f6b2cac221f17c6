// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/branches.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include "assembly/loop_closure.h"

namespace gelenk {
namespace {

// Where two branches meet, gaps of 1e-13 leave 3e-7 of the coordinates open; slopes of the distance likewise.
constexpr double one_place = 1e-5;
constexpr double bent = 1e-9;  // bending beside the weights below which the distance is flat

// Ends where nothing new was found in so many searches that closed: one with a third of an average share of the
// starts has been missed by then with a probability of about 1/1000.
int patience(std::size_t branches) { return 50 + 20 * static_cast<int>(branches); }

class Collector {
 public:
  Collector(AssemblyProblem& problem, Dynamics& dynamics, const std::vector<int>& links)
      : problem_(problem), dynamics_(dynamics), links_(links) {}

  // True if that is a new one. chosen: stays, whatever it is.
  bool add(const std::vector<double>& q, bool chosen) {
    Branch branch{.q = q, .distance = problem_.distance(q).norm(), .hits = 1, .chosen = chosen};
    const LocalMinimum minimum = local_minimum_at(problem_, q);
    branch.degrees_of_freedom = static_cast<int>(minimum.degrees_of_freedom);
    branch.flat = minimum.degrees_of_freedom > 0 && std::abs(minimum.least_curvature) < bent;
    // How far Newton's method sees the bottom from here.
    const bool at_bottom = branch.flat || minimum.degrees_of_freedom == 0 ||
                           (minimum.least_curvature > 0 && minimum.gradient / minimum.least_curvature < one_place / 10);
    if (!chosen && !at_bottom) return false;
    branch.poses = poses_at(q);
    const auto known = std::ranges::find_if(found_, [&](const Branch& other) { return same(other, branch); });
    if (known == found_.end()) {
      found_.push_back(std::move(branch));
      return true;
    }
    branch.hits = ++known->hits;
    if (!known->chosen && branch.distance < known->distance - one_place) *known = std::move(branch);
    return false;
  }

  std::size_t size() const { return found_.size(); }

  std::vector<Branch> nearest_first() && {
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

  bool same(const Branch& a, const Branch& b) const {
    if (a.flat && b.flat) return std::abs(a.distance - b.distance) < one_place * std::max(1.0, a.distance);
    if (links_.empty()) return problem_.apart(a.q, b.q) < one_place * problem_.length();
    for (std::size_t i = 0; i < links_.size(); ++i) {
      if ((a.poses[i].p - b.poses[i].p).norm() > one_place * problem_.length()) return false;
      if ((a.poses[i].R - b.poses[i].R).norm() > one_place) return false;
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
  // What nobody gave has less weight at the end of assemble() than in this search.
  std::vector<double> nearest = own.q;
  minimize_distance(problem, nearest);
  collector.add(nearest, true);
  std::mt19937 random(search.seed);
  int nothing_new = 0;
  while (out.starts < search.most_starts && !out.settled) {
    ++out.starts;
    std::vector<double> q = problem.scattered(random);
    if (close_loops(problem, q) > assembled_gap) continue;
    ++out.closed;
    problem.unwind(q);
    minimize_distance(problem, q);
    problem.unwind(q);
    nothing_new = collector.add(q, false) ? 0 : nothing_new + 1;
    out.settled = nothing_new >= patience(collector.size());
  }
  out.found = std::move(collector).nearest_first();
  std::ranges::find_if(out.found, &Branch::chosen)->q = own.q;
  return out;
}

}  // namespace gelenk
