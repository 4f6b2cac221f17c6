// SPDX-License-Identifier: BSD-3-Clause
#include "time_stepping/time_stepper.h"

#include <algorithm>
#include <cmath>

#include "complementarity/independent_parts.h"
#include "complementarity/redundant_impulses.h"
#include "kinematics/loads.h"
#include "math/bounds.h"
#include "nonsmooth/rounding.h"
#include "time_stepping/given_friction.h"
#include "time_stepping/step_limits.h"

namespace gelenk {
namespace {

// Of the relative velocities before a step, by which impulses may err at most: what is at rest has accurate forces.
constexpr double part_of_motion = 1e-3;
// Penetration that is removed within a step, relative to the smaller shape: the displacement is linear in the
// coordinates.
constexpr double max_correction = 0.1;
// Of each row, relative to that of the bodies; and part of the size of impulses below which others are smaller.
constexpr double compliance = 1e-4;
constexpr double less = 1 - 1e-6;
// Rows for which memory is taken at the start: some MB.
constexpr std::size_t max_reserved_rows = 200;

}  // namespace

TimeStepper::TimeStepper(const Mechanism& mechanism, Dynamics& dynamics, const Loads& loads, ImpulseAccuracy accuracy)
    : mechanism_(mechanism),
      dynamics_(dynamics),
      loads_(loads),
      accuracy_(accuracy),
      rows_(dynamics.switching_forces().contact_rows()),
      finder_(mechanism, loads.contacts.size()),
      rotation_(mechanism),
      operator_(rows_),
      solver_(std::make_unique<IndependentParts>(
          std::make_unique<SolverOfRedundant>(make_cone_solver(cone_solver_kinds().front().name)))),
      joints_(dynamics.switching_forces(), mechanism.nv),
      v0_(static_cast<std::size_t>(mechanism.nv)),
      v1_(v0_.size()),
      vm_(v0_.size()),
      vdot_(v0_.size()),
      vdot_before_(v0_.size()),
      dq_(v0_.size()),
      starts_(most_halvings + 1, std::vector<double>(static_cast<std::size_t>(mechanism.nq) + v0_.size())) {
  state_.locks.resize(static_cast<std::size_t>(dynamics.switching_forces().locks()));
  for (int i = 0; i < dynamics.switching_forces().locks(); ++i)
    state_.any_latch = state_.any_latch || dynamics.switching_forces().lock(i).latch >= 0;
  state_.wrenches.resize(mechanism.links.size());
  state_.along.resize(v0_.size());
  state_.sums.resize(loads.contacts.size());
  kept_ = second_ = state_;
  reserve();
}

// Allocates what all contacts at once need if they are few; later growth is geometric.
void TimeStepper::reserve() {
  std::size_t points = 0;
  std::size_t rows = 3 * static_cast<std::size_t>(dynamics_.switching_forces().locks());  // friction and two bounds
  finder_.each_pair([&](int contact) {
    const ContactLaw& law = loads_.contacts[static_cast<std::size_t>(contact)];
    const int size = Cone::contact(0, law.static_friction, law.spinning, law.rolling).size();
    points += max_contact_points;
    rows += max_contact_points * static_cast<std::size_t>(size);
    return rows < max_reserved_rows;
  });
  if (rows == 0) return;
  rows = std::min(rows, max_reserved_rows);
  points = std::min(points, max_reserved_rows);
  finder_.reserve(points);
  points_.reserve(points);
  frames_.reserve(points);
  turning_.reserve(points);
  opens_.reserve(points);
  for (auto* of : {&state_.contacts, &kept_.contacts, &second_.contacts, &last_contacts_}) of->reserve(points);
  cones_.reserve(rows);
  compression_cones_.reserve(rows);
  joints_.reserve(rows);
  strikes_.reserve(rows);
  restitution_.reserve(rows);
  for (std::vector<double>* of :
       {&b_, &x_, &speeds_, &free_speeds_, &belts_, &compression_, &least_, &after_, &displacing_, &relieved_})
    of->reserve(rows);
  correction_.reserve(rows);
  rows_.reserve(static_cast<int>(rows));
  operator_.reserve(rows);
  // The solver keeps the memory of the largest problem.
  const auto n = static_cast<Eigen::Index>(rows);
  const Eigen::MatrixXd G = Eigen::MatrixXd::Identity(n, n);
  b_.assign(rows, 0.0);
  x_.assign(rows, 0.0);
  cones_.clear();
  for (int i = 0; i < static_cast<int>(rows); ++i) cones_.push_back(Cone::within(i, 0, 0));
  const DenseConeOperator identity(G);
  solver_->solve({identity, b_, cones_, false}, {}, x_.data());
  cones_.clear();
}

TimeStepper::~TimeStepper() = default;

// The rows of all points and locks that may be reached within the step.
void TimeStepper::collect(double h) {
  rows_.clear();
  cones_.clear();
  joints_.clear();
  frames_.clear();
  points_.clear();
  if (mechanism_.touches())
    points_ = finder_.find(dynamics_.readings(), h, h * loads_.gravity.norm(), 2 * touch_tolerance);
  turning_.assign(points_.size(), Turning::no);
  opens_.assign(points_.size(), 0.0);
  for (const NearPoint& point : points_) add_contact(point, h);
  joints_.add({h, v0_.data(), vdot_.data(), state_.locks}, rows_, cones_);
  for (std::vector<double>* of : all_by_row()) of->assign(static_cast<std::size_t>(rows_.count()), 0.0);
  strikes_.clear();
  restitution_.clear();
  if (cones_.empty()) return;
  operator_.update();
  rows_.speeds(v0_.data(), speeds_.data());
  set_belts();
  set_friction(h);
  guess(h);
  find_strikes(h);
}

// Of limits that the velocities at the end of the step, v1_, lead beyond (JointRows).
void TimeStepper::add_passed_limits(double h) {
  const std::size_t before = cones_.size();
  joints_.add_passed_limits(h, v1_.data(), rows_, cones_);
  if (cones_.size() == before) return;
  for (std::vector<double>* of : all_by_row()) of->resize(static_cast<std::size_t>(rows_.count()), 0.0);
  strikes_.resize(cones_.size(), 0);
  operator_.update();
}

void TimeStepper::add_contact(const NearPoint& point, double h) {
  const ContactLaw& law = loads_.contacts[static_cast<std::size_t>(point.contact)];
  const Cone cone = cone_of(point, law, rows_.count(), h);
  const Eigen::Matrix3d axes = axes_of(point);
  const int a = point.link_a;
  const int b = point.link_b;
  for (const int link : {a, b}) rotation_.touch(link);
  if (!cone.is_ball) rows_.add(a, b, point.p, axes.col(0), point.turns);
  for (int i = 0; i < cone.tangential; ++i)
    rows_.add(a, b, point.p, axes.col(cone.is_ball ? i : 1 + i), cone.is_ball && point.turns);
  if (cone.spin > 0) rows_.add(a, b, point.p, axes.col(0), true);
  for (int i = 0; i < cone.roll; ++i) rows_.add(a, b, point.p, axes.col(1 + i), true);
  frames_.push_back(axes);
  cones_.push_back(cone);
}

// x_ <- the impulses of the last step.
void TimeStepper::guess(double h) {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const RememberedContact* before = state_.find(points_[i]);
    if (before == nullptr) continue;
    const Cone& cone = cones_[i];
    double* x = x_.data() + cone.first;
    if (cone.is_ball) {
      write_components(cone, frames_[i], h * (points_[i].turns ? before->moment : before->force), x);
      continue;
    }
    opens_[i] = opening(points_[i].gap, *before, h);
    *x++ = h * frames_[i].col(0).dot(points_[i].turns ? before->moment : before->force);
    for (int k = 0; k < cone.tangential; ++k) *x++ = h * frames_[i].col(1 + k).dot(before->force);
    if (cone.spin > 0) *x++ = h * frames_[i].col(0).dot(before->moment);
    for (int k = 0; k < cone.roll; ++k) *x++ = h * frames_[i].col(1 + k).dot(before->moment);
  }
  for (std::size_t i = 0; i < joints_.count(); ++i) {
    const Cone& cone = cones_[points_.size() + i];
    const LockForces& last = state_.locks[static_cast<std::size_t>(joints_[i].lock)];
    const double force = joints_[i].is_latch ? last.latch : joints_[i].side == 0 ? last.friction : last.limit;
    x_[static_cast<std::size_t>(cone.first)] = std::clamp(h * force, cone.lower, cone.upper);
  }
}

double TimeStepper::fastest() const { return fastest_of(free_speeds_, fastest_of(speeds_, residual_floor)); }

// Residual of velocities that a solution may leave.
double TimeStepper::velocity_tolerance() const {
  const double moves = fastest_of(speeds_, 0);
  return std::max(accuracy_.relative * fastest(), std::min(accuracy_.absolute, part_of_motion * moves));
}

void TimeStepper::solve_impulses() {
  if (has_compression_) {
    for (std::size_t r = 0; r < x_.size(); ++r) x_[r] -= least_[r];
  }
  solve(cones_, x_);
  if (may_be_prestressed()) relieve();
  if (has_compression_) {
    for (std::size_t r = 0; r < x_.size(); ++r) x_[r] += least_[r];
  }
}

// x <- the impulses in these cones, for the velocities b_.
void TimeStepper::solve(const std::vector<Cone>& cones, std::vector<double>& x) {
  if (recorded_ != nullptr) recorded_->emplace_back(ConeProblem{operator_, b_, cones, true});
  const ConeResult result = solve_for(cones, x, may_remain_at_rest());
  last_residual_ = result.residual;
  solved_.residual = std::max(solved_.residual, result.residual);
  solved_.iterations = std::max(solved_.iterations, result.iterations);
}

bool TimeStepper::may_remain_at_rest() const {
  return !strikes_any_ && operator_.dense() != nullptr && !state_.contacts.empty() &&
         std::ranges::none_of(state_.contacts, &RememberedContact::slides);
}

ConeResult TimeStepper::solve_for(const std::vector<Cone>& cones, std::vector<double>& x, bool may_rest) {
  ConeOptions options;
  options.tolerance = velocity_tolerance();
  options.max_iterations = most_cone_iterations;
  const ConeProblem problem{operator_, b_, cones, true};
  const ConeResult result =
      may_rest ? rest_first_.solve(*solver_, problem, options, std::max(rest_speed, options.tolerance), x.data())
               : solver_->solve(problem, options, x.data());
  dynamics_.count_evaluations(excess_iterations(result.iterations));
  return result;
}

// Whether this is no solution at all.
bool TimeStepper::misses(double residual) const { return residual > impossible_fraction * fastest(); }

// Whether a limit or a one-way clutch and a point with friction push, and one of them has not in the last step. They
// may push against each other; the friction of such a prestress could hold what would slide without it.
bool TimeStepper::may_be_prestressed() const {
  if (operator_.dense() == nullptr) return false;
  bool any_limit = false, any_point = false, any_new = strikes_any_;
  for (std::size_t i = 0; i < cones_.size(); ++i) {
    const Cone& cone = cones_[i];
    if (cone.is_ball || x_[static_cast<std::size_t>(cone.first)] == 0) continue;
    if (i < points_.size()) {
      any_point = any_point || cone.size() > 1;
      any_new = any_new || state_.find(points_[i]) == nullptr;
    } else if (const JointRows::Row& row = joints_[i - points_.size()]; row.side != 0) {
      any_limit = true;
      any_new = any_new || state_.locks[static_cast<std::size_t>(row.lock)].limit == 0;
    }
  }
  return any_limit && any_point && any_new;
}

// Rigid bodies permit any prestress: x_ <- the impulses that are found from those of slightly compliant ones, which
// have none, if they are smaller.
void TimeStepper::relieve() {
  relieved_.assign(x_.size(), 0.0);
  operator_.soften(compliance);
  solve_for(cones_, relieved_);
  operator_.update();
  const ConeResult result = solve_for(cones_, relieved_);
  if (!result.converged || operator_.size_of(relieved_) > less * operator_.size_of(x_)) return;
  x_.swap(relieved_);
  solved_.iterations = std::max(solved_.iterations, result.iterations);
}

// The gap that the first row of a cone changes: of a point or, with the sign of its rate, of a limit; friction has
// none.
TimeStepper::Gap TimeStepper::gap_of(std::size_t cone) const {
  if (cone < points_.size()) return {points_[cone].gap, cones_[cone].is_ball ? 0 : 1};
  const JointRows::Row& lock = joints_[cone - points_.size()];
  return {-lock.depth, lock.is_of_speed ? 0 : -lock.side};
}

// Returns whether positions at the end of the step need a correction. hold: which joints at rest do not move by it, but
// for latches that have passed a limit, which return to it in any case.
bool TimeStepper::find_corrections(double h, JointRows::Hold hold) {
  correction_.clear();
  const double slow = std::max(rest_speed, left_tolerances * velocity_tolerance());
  bool any = false;
  for (std::size_t i = 0; i < cones_.size(); ++i) {
    const double speed = free_speeds_[static_cast<std::size_t>(cones_[i].first)];
    const Gap at = gap_of(i);
    if (at.sign == 0) {
      if (i < points_.size() || !(std::abs(speed) <= slow)) continue;
      const JointRows::Row& joint = joints_[i - points_.size()];
      any = any || joint.passed != 0;
      const bool holds = joints_.may_hold(joint, hold, h, joint_cones(), free_speeds_.data());
      if (holds || joint.passed != 0) correction_.hold(joint, cones_[i]);
      continue;
    }
    double gap = at.gap + at.sign * h / 2 * speed;
    if (i < points_.size()) {
      const double size = std::min(finder_.size(points_[i].a), finder_.size(points_[i].b));
      gap = std::max(gap + opens_[i] / 4, -max_correction * size);  // opens_: in the second half of the step
    }
    const bool closes = gap > touch_tolerance && remains_struck(i);
    any = any || closes || gap < -touch_tolerance;
    correction_.add(cones_[i].first, at.sign * gap, at.sign < 0 || closes ? -unlimited : 0,
                    at.sign > 0 || closes ? unlimited : 0);
  }
  return any;
}

// Adds to dq the smallest displacement that ends all penetrations that remain at the end of the step, and all gaps of
// what has been struck without restitution. What is held at rest moves only where nothing else can end them, and what
// friction holds before what is latched, whose limits have no rows.
void TimeStepper::correct_position(double h, double* dq) {
  if (cones_.empty()) return;
  rows_.speeds(v1_.data(), free_speeds_.data());
  const double tolerance = std::max(touch_tolerance, h * velocity_tolerance()) / 10;
  for (const auto hold : {JointRows::Hold::all, JointRows::Hold::latches, JointRows::Hold::none}) {
    if (!find_corrections(h, hold)) return;
    std::ranges::fill(displacing_, 0.0);
    const ConeResult result = correction_.solve(operator_, *solver_, tolerance, displacing_);
    solved_.iterations = std::max(solved_.iterations, result.iterations);
    if (result.converged) break;
  }
  rows_.strike(displacing_.data(), dq);
}

}  // namespace gelenk
