// SPDX-License-Identifier: BSD-3-Clause
#include "event_driven/contact_decision.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "event_driven/decision_limits.h"
#include "math/bounds.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Relative accelerations of what breaks away at this instant are larger than this fraction of the largest.
constexpr double least_acceleration = 1e-12;
// Error of accelerations of a solution of the cone problem, relative to the largest.
constexpr double decision_cone_tolerance = 1e-13;
// Repetitions with the friction of what slides, which follows from the normal forces.
constexpr int most_repetitions = 200;
// The first of these begin with static friction, since what can hold does.
constexpr int most_fresh_starts = 20;
constexpr int decision_cone_iterations = 500;
constexpr std::size_t most_tried_locks = 4;

// A vector with these components along the axes of a group.
Eigen::Vector3d in_space(const ContactEquations::Entry& entry, int group, const VectorXd& part) {
  Eigen::Vector3d out = Eigen::Vector3d::Zero();
  for (Index k = 0; k < part.size(); ++k) out += part[k] * entry.axis(group, k);
  return out;
}

// The cones of a candidate; opens: that it has no force. given: its normal force, if that is given.
void add_cones(const ContactEquations::Entry& entry, const std::array<double, contact_groups>& coefficients,
               double given, bool opens, std::vector<Cone>& out) {
  if (entry.is_given) {
    out.push_back(Cone::within(entry.first, given, given));
    if (entry.rows[0] >= 0) out.push_back(Cone::ball(entry.rows[0], entry.kept(0), coefficients[0] * given));
    return;
  }
  const Cone cone = cone_of(entry, coefficients);
  if (!opens) return out.push_back(cone);
  for (int k = 0; k < cone.size(); ++k) out.push_back(Cone::within(cone.first + k, 0, 0));
}

// Of the normal forces, by candidate, that are not given.
double largest_pressure(const std::vector<ContactEquations::Entry>& entries, const VectorXd& normal) {
  double out = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (!entries[i].is_given) out = std::max(out, normal[static_cast<Index>(i)]);
  }
  return out;
}

// Whether a joint has used up its limit, which with other normal forces it might not.
bool uses_any_up(const LockProblem& problem) {
  return std::ranges::any_of(problem.locks, [](const LockProblem::Lock& lock) { return lock.direction != 0; });
}

bool begins_to_move(const CandidateMode& before, const CandidateMode& after, std::size_t group) {
  return after.closed && after.groups[group].moves && !before.groups[group].moves;
}

void symmetrize(Eigen::MatrixXd& G) { G = Eigen::MatrixXd((G + G.transpose()) / 2); }

// What joints that are locked hold along its normal, and no friction holds, has no force: its response is rounding, and
// would become a divisor. Z: of R.
void open_blocked(const ContactEquations::Rows& rows, const ContactEquations::RowMatrix& Z, Eigen::MatrixXd& G,
                  Eigen::MatrixXd& C, VectorXd& b, std::vector<char>& opens) {
  for (std::size_t i = 0; i < rows.entries.size(); ++i) {
    const Index row = rows.entries[i].first;
    const bool may_be_held =
        rows.entries[i].is_given || std::ranges::any_of(rows.entries[i].rows, [](int of) { return of >= 0; });
    if (may_be_held || !is_blocked(G(row, row), rows.R.row(row).norm(), Z.col(row).norm())) continue;
    G.row(row).setZero();
    G.col(row).setZero();
    C.row(row).setZero();
    b[row] = 0;
    G(row, row) = G.cwiseAbs().maxCoeff() > 0 ? G.cwiseAbs().maxCoeff() : 1;
    opens[i] = 1;
  }
}

// Of a force within its bounds, although the joint is accelerated: 1, -1: it moves in this direction; 0: it does not.
// All that the force can change of the acceleration may be less than the tolerance of the problem, as of friction where
// a linkage reverses the joint: in such a position almost nothing moves it.
int moving_away(const Cone& cone, double acceleration, double rounding) {
  if (std::abs(acceleration) <= rounding) return 0;
  if (acceleration > 0) return std::isfinite(cone.lower) ? 1 : 0;
  return std::isfinite(cone.upper) ? -1 : 0;
}

}  // namespace

ContactDecision::ContactDecision(ContactEquations& equations)
    : equations_(equations), solver_(make_cone_solver(cone_solver_kinds().front().name)) {}

// What has let go has no force, at first.
void ContactDecision::set_cones() {
  cones_.clear();
  for (std::size_t i = 0; i < rows_.entries.size(); ++i) {
    const ContactEquations::Entry& entry = rows_.entries[i];
    std::array<double, contact_groups> coefficients{};
    for (int group = 0; group < contact_groups; ++group) {
      const auto g = static_cast<std::size_t>(group);
      coefficients[g] = equations_.coefficient(entry.candidate, group, slides_[i][g]);
      if (breaks_away_) coefficients[g] *= 1 - break_away_fraction;
    }
    add_cones(entry, coefficients, equations_.law(entry.candidate).given_normal, opens_[i] != 0, cones_);
  }
  set_lock_cones();
}

void ContactDecision::set_lock_cones() {
  const auto& locks = problem_->locks;
  const double part = breaks_away_ ? 1 - break_away_fraction : 1;
  for (std::size_t i = 0; i < locks.size(); ++i) {
    const DirectedLimit& friction = slips_[i] != 0 ? locks[i].slipping : locks[i].sticking;
    cones_.push_back(Cone::within(first_lock_ + static_cast<int>(i), locks[i].lower(friction, part),
                                  locks[i].upper(friction, part)));
  }
}

// What is at a limit and is accelerated against it.
void ContactDecision::answer_locks() {
  const VectorXd a = G_ * x_ + C_ * normal_forces() + b_;
  for (std::size_t i = 0; i < problem_->locks.size(); ++i) {
    LockProblem::Lock& lock = problem_->locks[i];
    const int row = first_lock_ + static_cast<int>(i);
    const Cone& cone = cones_[cones_.size() - problem_->locks.size() + i];
    const double slack = limit_fraction * std::max(lock.sticking.largest(), least_force * x_.cwiseAbs().maxCoeff());
    lock.direction = 0;
    if (x_[row] >= cone.upper - slack) lock.direction = -1;
    if (x_[row] <= cone.lower + slack && (lock.direction == 0 || a[row] > 0)) lock.direction = 1;
    if (lock.direction == 0) lock.direction = moving_away(cone, a[row], limit_fraction * scale_);
    // What exceeds its limit by more than rounding leaves, however fast others are accelerated.
    const double noticed = std::min(lock.noticed, limit_fraction * scale_);
    const double least =
        breaks_away_ ? std::min(noticed, least_acceleration * scale_) : std::max(noticed, least_acceleration * scale_);
    lock.leaves = lock.direction * a[row] > least;
  }
}

// Static friction of joints that does not hold becomes sliding friction; returns whether that is less.
bool ContactDecision::let_locks_slip() {
  bool changed = false;
  for (std::size_t i = 0; i < problem_->locks.size(); ++i) {
    const LockProblem::Lock& lock = problem_->locks[i];
    if (!lock.leaves || slips_[i] != 0) continue;
    slips_[i] = 1;
    changed = changed || lock.slipping.largest() < lock.sticking.largest();
  }
  return changed;
}

// normal: the normal forces from which the friction of what slides follows.
void ContactDecision::solve_cones(const VectorXd& normal) {
  const VectorXd b = b_ + C_ * normal;
  ConeOptions options;
  options.tolerance = decision_cone_tolerance * scale_;
  options.max_iterations = decision_cone_iterations;
  const DenseConeOperator G(G_);
  const std::span<const double> right(b.data(), static_cast<std::size_t>(b.size()));
  const ConeProblem problem{G, right, cones_, true};
  iterations_ += rest_first_.solve(*solver_, problem, options, limit_fraction * scale_, x_.data()).iterations;
}

std::vector<CandidateMode> ContactDecision::modes_of_solution(const std::vector<CandidateMode>& tentative) const {
  std::vector<CandidateMode> next = tentative;
  const VectorXd normal = normal_forces();
  const double largest = largest_pressure(rows_.entries, normal);
  const VectorXd a = G_ * x_ + C_ * normal + b_;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const ContactEquations::Entry& entry = rows_.entries[i];
    CandidateMode& mode = next[static_cast<std::size_t>(candidates_[i])];
    const double n = x_[entry.first];
    const bool pushes = entry.is_given || n > least_force * largest;
    mode.closed = pushes || (opens_[i] == 0 && a[entry.first] <= limit_fraction * scale_);
    if (!mode.closed) continue;
    for (int group = 0; group < contact_groups; ++group) {
      const auto g = static_cast<std::size_t>(group);
      if (entry.rows[g] < 0) continue;
      mode.groups[g].moves = false;
      mode.groups[g].direction.setZero();
      if (pushes) {
        find_motion(i, group, a, mode);
      } else if (const VectorXd part = a.segment(entry.rows[g], entry.kept(group));
                 part.norm() > limit_fraction * scale_) {
        mode.groups[g] = {true, in_space(entry, group, part / part.norm())};  // without a force, there is no friction
      }
    }
  }
  return next;
}

// Whether friction of a group is at its limit, and what moves against it.
void ContactDecision::find_motion(std::size_t i, int group, const VectorXd& a, CandidateMode& mode) const {
  const ContactEquations::Entry& entry = rows_.entries[i];
  const auto g = static_cast<std::size_t>(group);
  const auto part = x_.segment(entry.rows[g], entry.kept(group));
  const double limit = equations_.coefficient(entry.candidate, group, slides_[i][g]) * x_[entry.first];
  const double size = part.norm();
  if (!(size >= limit * (1 - 2 * break_away_fraction) && size > 0)) return;
  // Redundant forces may be at their limits although nothing moves.
  const double along = -part.dot(a.segment(entry.rows[g], entry.kept(group))) / size;
  if (!(along > (breaks_away_ ? least_acceleration : limit_fraction) * scale_)) return;
  mode.groups[g] = {true, in_space(entry, group, -part / size)};
}

// What begins to move does so against its friction at the limits themselves: with friction that is reduced so that it
// moves, the direction is in error by as much, and nothing else accelerates it at this instant.
void ContactDecision::find_directions(const std::vector<CandidateMode>& tentative, const VectorXd& normal,
                                      std::vector<CandidateMode>& next) {
  const auto begins = [&](int candidate, std::size_t g) {
    const auto at = static_cast<std::size_t>(candidate);
    return begins_to_move(tentative[at], next[at], g);
  };
  const auto any_begins = [&](int of) { return begins(of, 0) || begins(of, 1) || begins(of, 2); };
  if (std::ranges::none_of(candidates_, any_begins)) return;
  const VectorXd reduced = x_;
  breaks_away_ = false;
  set_cones();
  solve_cones(normal);
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const ContactEquations::Entry& entry = rows_.entries[i];
    for (int group = 0; group < contact_groups; ++group) {
      const auto g = static_cast<std::size_t>(group);
      if (entry.rows[g] < 0 || !begins(candidates_[i], g)) continue;
      const VectorXd part = x_.segment(entry.rows[g], entry.kept(group));
      const double limit = equations_.coefficient(entry.candidate, group, slides_[i][g]) * x_[entry.first];
      if (part.norm() < limit * (1 - 2 * break_away_fraction) || part.isZero(0)) continue;
      next[static_cast<std::size_t>(candidates_[i])].groups[g].direction = in_space(entry, group, -part / part.norm());
    }
  }
  breaks_away_ = true;
  x_ = reduced;
  set_cones();
}

VectorXd ContactDecision::normal_forces() const {
  VectorXd out(static_cast<Index>(candidates_.size()));
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const ContactEquations::Entry& entry = rows_.entries[i];
    out[static_cast<Index>(i)] = entry.is_given ? equations_.law(entry.candidate).given_normal : x_[entry.first];
  }
  return out;
}

// Static friction that does not hold becomes sliding friction, which may be less; returns whether it is.
bool ContactDecision::let_slide(const std::vector<CandidateMode>& tentative, const std::vector<CandidateMode>& next) {
  bool changed = let_locks_slip();
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const int point = candidates_[i];
    const auto at = static_cast<std::size_t>(point);
    for (std::size_t g = 0; g < contact_groups; ++g) {
      if (!begins_to_move(tentative[at], next[at], g) || slides_[i][g]) continue;
      slides_[i][g] = true;
      const int group = static_cast<int>(g);
      changed = changed || equations_.coefficient(point, group, true) != equations_.coefficient(point, group, false);
    }
    if (opens_[i] == 0) continue;
    const double leaving = (G_ * x_ + C_ * normal_forces() + b_)[rows_.entries[i].first];
    if (leaving >= -acceleration_tolerance * scale_) continue;
    opens_[i] = 0;
    changed = true;
  }
  return changed;
}

// The rows of locks follow those of contacts.
void ContactDecision::add_lock_rows() {
  first_lock_ = static_cast<int>(rows_.R.rows());
  const auto& locks = problem_->locks;
  slips_.assign(locks.size(), 0);
  if (locks.empty()) return;
  const auto all = first_lock_ + static_cast<Index>(locks.size());
  rows_.R.conservativeResize(all, Eigen::NoChange);
  rows_.rates.conservativeResize(all);
  for (std::size_t i = 0; i < locks.size(); ++i) {
    const Index row = first_lock_ + static_cast<Index>(i);
    rows_.R.row(row) = locks[i].row;
    rows_.rates[row] = 0;
  }
}

void ContactDecision::set_up(const std::vector<CandidateMode>& tentative, const std::vector<Trigger>& triggered,
                             const double* vdot) {
  equations_.build(candidates_, tentative, true, rows_);
  add_lock_rows();
  ContactEquations::RowMatrix Z;
  C_.setZero(rows_.R.rows(), static_cast<Index>(candidates_.size()));
  if (rows_.any_moves()) {
    equations_.respond(rows_.D, Z);
    C_ = rows_.R * Z;
  }
  equations_.respond(rows_.R, Z);
  G_ = rows_.R * Z;
  symmetrize(G_);
  const Eigen::Map<const VectorXd> free(vdot, rows_.R.cols());
  b_ = rows_.R * free + rows_.rates;
  scale_ = std::max(b_.cwiseAbs().maxCoeff(), (rows_.R.cwiseAbs() * free.cwiseAbs()).maxCoeff());
  breaks_away_ = problem_->breaks_away() || std::ranges::any_of(candidates_, [&](int candidate) {
                   const auto& groups = triggered[static_cast<std::size_t>(candidate)].groups;
                   return std::ranges::find(groups, true) != groups.end();
                 });
  slides_.assign(candidates_.size(), {});
  opens_.assign(candidates_.size(), 0);
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    opens_[i] = triggered[static_cast<std::size_t>(candidates_[i])].leaves ? 1 : 0;
  }
  open_blocked(rows_, Z, G_, C_, b_, opens_);
  x_.setZero(b_.size());
}

// Where friction of what slides makes a joint that friction holds move the other way (as in Painleve's paradox), the
// forces above do not settle although one motion obeys the laws: each combination of rest and both directions is tried.
bool ContactDecision::try_locks(const double* vdot, std::vector<CandidateMode>& next) {
  const std::size_t count = problem_->locks.size();
  if (count == 0 || count > most_tried_locks) return false;
  const std::vector<CandidateMode> first = next;
  const std::vector<LockProblem::Lock> answers = problem_->locks;
  std::size_t combinations = 1;
  for (std::size_t i = 0; i < count; ++i) combinations *= 3;
  for (std::size_t k = 0; k < combinations; ++k) {
    std::size_t rest = k;
    for (LockProblem::Lock& lock : problem_->locks) {
      lock.direction = std::array{0, 1, -1}[rest % 3];  // what can remain at rest does
      lock.leaves = lock.direction != 0;
      rest /= 3;
    }
    next = first;
    const bool possible = std::ranges::none_of(
        problem_->locks, [](const auto& lock) { return lock.contact != 0 && lock.direction == lock.contact; });
    if (possible && refine(vdot, next) && !exceeds_limits()) return true;
  }
  next = first;
  problem_->locks = answers;
  return false;
}

// NOLINTNEXTLINE(readability-function-cognitive-complexity): one loop, whose exits share its state
ContactDecision::Outcome ContactDecision::decide(const std::vector<int>& candidates,
                                                 const std::vector<Trigger>& triggered, const double* vdot,
                                                 std::vector<CandidateMode>& next, LockProblem& problem) {
  const std::vector<CandidateMode> tentative = next;
  candidates_ = candidates;
  problem_ = &problem;
  iterations_ = 0;
  set_up(tentative, triggered, vdot);
  VectorXd normal = normal_forces();  // those that are given
  Outcome outcome = Outcome::none;
  // Modes that obey the laws although something might hold with the normal forces in them.
  std::vector<CandidateMode> possible;
  std::vector<LockProblem::Lock> possible_locks;
  for (int k = 0; k < most_repetitions; ++k) {
    set_cones();
    solve_cones(normal);
    next = modes_of_solution(tentative);
    answer_locks();
    if (let_slide(tentative, next)) continue;
    if (breaks_away_) find_directions(tentative, normal, next);
    has_consistent_friction_ = slides_with(normal);
    if (refine(vdot, next)) {
      const VectorXd found = normal_forces_in_modes();
      const double change = (found - normal).cwiseAbs().maxCoeff();
      const bool same = !rows_.any_moves() || change <= limit_fraction * found.cwiseAbs().maxCoeff();
      if (same && rows_.any_moves() && !slides_with(found) && locks_exceed_limits()) break;
      const bool obeys_all = same || !exceeds_limits();
      if (same || (obeys_all && !uses_any_up(problem)))
        return is_indeterminate(next) ? Outcome::ambiguous : Outcome::found;
      if (obeys_all && possible.empty()) {
        possible = next;
        possible_locks = problem.locks;
      }
      normal = found;
      if (k < most_fresh_starts) std::ranges::fill(slips_, 0);
      continue;
    }
    const VectorXd before = normal;
    normal = normal_forces();
    if (!normal.allFinite()) break;
    if ((normal - before).cwiseAbs().maxCoeff() > limit_fraction * normal.cwiseAbs().maxCoeff()) continue;
    outcome = Outcome::ambiguous;
    break;
  }
  if (possible.empty()) return try_locks(vdot, next) ? Outcome::found : outcome;
  next = std::move(possible);
  problem.locks = std::move(possible_locks);
  return Outcome::found;
}

}  // namespace gelenk
