// SPDX-License-Identifier: BSD-3-Clause
// Whether what has been decided on contacts obeys the laws: the part of ContactDecision that checks.
#include <algorithm>
#include <cmath>
#include <ranges>

#include "event_driven/contact_decision.h"
#include "event_driven/decision_limits.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Whether a candidate is accelerated as its mode permits. relative: by row.
bool obeys(const ContactEquations::Entry& entry, const CandidateMode& mode, const VectorXd& relative,
           double tolerance) {
  if (!mode.closed) return !(relative[entry.first] < -tolerance);
  if (std::abs(relative[entry.first]) > tolerance) return false;
  for (int group = 0; group < contact_groups; ++group) {
    const auto g = static_cast<std::size_t>(group);
    if (entry.rows[g] < 0) continue;
    if (!mode.groups[g].moves) {
      if (relative.segment(entry.rows[g], entry.kept(group)).cwiseAbs().maxCoeff() > tolerance) return false;
      continue;
    }
    double along = 0;
    for (Index k = 0; k < entry.kept(group); ++k)
      along += relative[entry.rows[g] + k] * entry.axis(group, k).dot(mode.groups[g].direction);
    if (along < -tolerance) return false;
  }
  return true;
}

// Of the rows of candidates: G x + C n + b, of forces x and normal forces n of what slides.
struct Accelerations {
  const Eigen::MatrixXd &G, &C;
  const VectorXd& b;
};

// Whether other modes obey the laws, too: flight where what slides remains in contact, or contact of one that flies.
// With much friction, a normal force on what slides may draw it into contact (Painleve 1895).
bool are_other_modes_possible(const std::vector<ContactEquations::Entry>& entries, const Accelerations& of,
                              double tolerance, const std::vector<CandidateMode>& next) {
  const auto rises = [&](const VectorXd& a) {
    return std::ranges::all_of(entries, [&](const auto& each) { return each.is_given || a[each.first] > tolerance; });
  };
  if (std::ranges::all_of(entries, &ContactEquations::Entry::is_given) || !rises(of.b)) return false;
  const auto is_closed = [&](const ContactEquations::Entry& entry) {
    return !entry.is_given && next[static_cast<std::size_t>(entry.candidate)].closed;
  };
  if (std::ranges::any_of(entries, is_closed)) return true;
  for (Index i = 0; i < of.C.cols(); ++i) {
    const Index row = entries[static_cast<std::size_t>(i)].first;
    const VectorXd per_force = of.G.col(row) + of.C.col(i);
    if (!(per_force[row] < 0)) continue;
    VectorXd a = of.b - of.b[row] / per_force[row] * per_force;
    a[row] = of.b[row];  // in contact
    if (rises(a)) return true;
  }
  return false;
}

}  // namespace

bool ContactDecision::locks_obey(const VectorXd& relative) const {
  for (std::size_t i = 0; i < problem_->locks.size(); ++i) {
    const LockProblem::Lock& lock = problem_->locks[i];
    const double along = lock.direction * relative[first_lock_ + static_cast<int>(i)];
    if (lock.leaves && along < -acceleration_tolerance * scale_) return false;
  }
  return true;
}

// Whether a candidate has a normal force in the cone problem with joints at rest and the friction of what slides.
bool ContactDecision::presses(int candidate) const {
  if (problem_->locks.empty() || !has_consistent_friction_) return false;
  const auto i = static_cast<std::size_t>(std::ranges::find(candidates_, candidate) - candidates_.begin());
  return i < candidates_.size() && x_[rows_.entries[i].first] > least_force * x_.cwiseAbs().maxCoeff();
}

// By candidate: in the modes of the last check().
VectorXd ContactDecision::normal_forces_in_modes() {
  VectorXd out = VectorXd::Zero(static_cast<Index>(candidates_.size()));
  const auto& forces = equations_.forces();
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const auto at = std::ranges::find(candidates_, equations_.closed()[i]) - candidates_.begin();
    if (at < out.size()) out[at] = forces[i].normal;
  }
  return out;
}

// In the modes of the last check().
int ContactDecision::side_beyond_limit(std::size_t i) const {
  const Cone& cone = cones_[cones_.size() - problem_->locks.size() + i];
  return problem_->locks[i].side_beyond(cone.lower, cone.upper);
}

bool ContactDecision::locks_exceed_limits() const {
  const auto all = std::views::iota(std::size_t{0}, problem_->locks.size());
  return std::ranges::any_of(all, [&](std::size_t i) { return side_beyond_limit(i) != 0; });
}

// Where a joint at rest and a contact hold the same motion, their forces are redundant, but the friction of what slides
// depends on them: what cannot hold alone gives way to the contact, and a contact that need not hold has no force.
// Returns whether any has changed.
bool ContactDecision::resolve_redundancy(std::vector<CandidateMode>& next) {
  if (problem_->locks.empty() || equations_.closed().empty() || !equations_.rows().any_moves()) return false;
  bool releases = false, opens = false;
  for (std::size_t i = 0; i < equations_.closed().size(); ++i) {
    if (!equations_.rows().entries[i].any_moves() || !is_blocked(equations_, i)) continue;
    const int candidate = equations_.closed()[i];
    releases = let_go_beyond_limits(candidate) || releases;
    if (releases) continue;
    next[static_cast<std::size_t>(candidate)].closed = false;
    opens = true;
  }
  return releases || opens;
}

// Of the joints at rest that a normal force on a candidate moves, those that need more than they can exert.
bool ContactDecision::let_go_beyond_limits(int candidate) {
  const auto at = static_cast<std::size_t>(std::ranges::find(candidates_, candidate) - candidates_.begin());
  const VectorXd per_force = G_.col(rows_.entries[at].first);
  bool any = false;
  for (std::size_t i = 0; i < problem_->locks.size(); ++i) {
    const int beyond = side_beyond_limit(i);
    const double moves = std::abs(per_force[first_lock_ + static_cast<Index>(i)]);
    if (beyond == 0 || moves <= limit_fraction * per_force.cwiseAbs().maxCoeff()) continue;
    LockProblem::Lock& lock = problem_->locks[i];
    lock.leaves = any = true;
    lock.direction = -beyond;
  }
  return any;
}

// Whether what slides has these normal forces, by candidate, in the cone problem: then its solution obeys the laws, and
// redundant forces on what is at rest may be distributed otherwise in the modes.
bool ContactDecision::slides_with(const VectorXd& normal) const {
  const double largest = normal.cwiseAbs().maxCoeff();
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const ContactEquations::Entry& entry = rows_.entries[i];
    const double change = std::abs(x_[entry.first] - normal[static_cast<Index>(i)]);
    if (entry.any_moves() && change > 2 * break_away_fraction * largest) return false;
  }
  return true;
}

// Whether friction that holds in these modes needs more than its limit, or a limit of a joint would have to pull.
bool ContactDecision::exceeds_limits() {
  if (locks_exceed_limits()) return true;
  const auto& forces = equations_.forces();
  double sum = 0;
  for (const auto& force : forces) sum += std::abs(force.normal);
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const ContactEquations::Entry& entry = equations_.rows().entries[i];
    for (int group = 0; group < contact_groups; ++group) {
      const auto g = static_cast<std::size_t>(group);
      if (entry.rows[g] < 0) continue;
      const double limit = equations_.coefficient(entry.candidate, group, false) * forces[i].normal;
      if (forces[i].held[g] > limit + (breaks_away_ ? -break_away_fraction * limit : limit_fraction * sum)) return true;
    }
  }
  return false;
}

// The closed contact with the most negative normal force; -1: none. Where joints at rest exert redundant forces, which
// are not those of the cone problem, contacts that press in that do not count.
int ContactDecision::most_pulling() const {
  double largest = 0;
  const auto& forces = equations_.forces();
  for (const auto& force : forces) largest = std::max(largest, std::abs(force.normal));
  double least = -acceleration_tolerance * largest;
  int out = -1;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const bool is_redundant = !equations_.are_unique() || is_blocked(equations_, i);
    if (!(forces[i].normal < least) || (is_redundant && presses(equations_.closed()[i]))) continue;
    least = forces[i].normal;
    out = equations_.closed()[i];
  }
  return out;
}

// Whether accelerations in these modes obey the laws. pulls: see most_pulling().
bool ContactDecision::check(const double* vdot, const std::vector<CandidateMode>& next, int& pulls) {
  equations_.set_modes(next);
  VectorXd a = Eigen::Map<const VectorXd>(vdot, rows_.R.cols());
  if (problem_->locks.empty()) {
    equations_.accelerate(a.data());
  } else {
    problem_->accelerate(a.data());
  }
  pulls = most_pulling();
  if (pulls >= 0 || !a.allFinite()) return false;
  const VectorXd relative = rows_.R * a + rows_.rates;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const CandidateMode& mode = next[static_cast<std::size_t>(candidates_[i])];
    if (!obeys(rows_.entries[i], mode, relative, acceleration_tolerance * scale_)) return false;
  }
  return locks_obey(relative);
}

// Drops closed contacts and limits of joints that would pull until none does.
bool ContactDecision::refine(const double* vdot, std::vector<CandidateMode>& next) {
  for (std::size_t k = 0; k <= 2 * candidates_.size() + problem_->locks.size(); ++k) {
    int pulls = -1;
    if (check(vdot, next, pulls)) {
      if (resolve_redundancy(next)) continue;
      return true;
    }
    if (pulls < 0) return false;
    next[static_cast<std::size_t>(pulls)].closed = false;
  }
  return false;
}

bool ContactDecision::is_indeterminate(const std::vector<CandidateMode>& next) const {
  if (!rows_.any_moves() || !problem_->locks.empty()) return false;
  return are_other_modes_possible(rows_.entries, {G_, C_, b_}, acceleration_tolerance * scale_, next);
}

}  // namespace gelenk
