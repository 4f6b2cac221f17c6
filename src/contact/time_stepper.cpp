// SPDX-License-Identifier: BSD-3-Clause
#include "contact/time_stepper.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gelenk {
namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

// Points with a tangential speed up to this stick at the start of a step [natural units of speed]: what the solver
// leaves of zero.
constexpr double rest_speed = 1e-9;
// Residual of the velocities of contacts [natural units of speed], relative to the largest velocity or 1e-3.
constexpr double residual_tolerance = 1e-11;
constexpr double residual_floor = 1e-3;
constexpr int max_iterations = 200;
// Rows up to which the Delassus operator is a matrix: larger ones cost more than they save. Sparse methods, which
// bodies without loops permit, are faster from a hundred rows on.
constexpr int max_dense_rows = 400;
constexpr int max_dense_rows_with_root = 100;

// Axes with the first along n; a continuous function of n nearly everywhere.
Eigen::Matrix3d contact_axes(const Eigen::Vector3d& n) {
  Eigen::Matrix3d out = rotation_taking_z_to(n);
  const Eigen::Vector3d z = out.col(2);
  out.col(2) = out.col(1);
  out.col(1) = out.col(0);
  out.col(0) = z;
  return out;
}

bool all_finite(const std::vector<double>& x) {
  return std::ranges::all_of(x, [](double value) { return std::isfinite(value); });
}

}  // namespace

// The Delassus operator of the present rows: a matrix if they are few.
class TimeStepper::Operator final : public ConeOperator {
 public:
  explicit Operator(const ContactRows& rows) : rows_(rows) {}

  // Call when the rows have changed.
  void update() {
    const int n = rows_.count();
    is_dense_ = n <= (root().first.empty() ? max_dense_rows : max_dense_rows_with_root);
    if (!is_dense_) return;
    G_.resize(n, n);
    unit_.assign(static_cast<std::size_t>(n), 0.0);
    for (int j = 0; j < n; ++j) {
      unit_[static_cast<std::size_t>(j)] = 1;
      rows_.apply(unit_.data(), G_.col(j).data());
      unit_[static_cast<std::size_t>(j)] = 0;
    }
    G_ = (G_ + G_.transpose()).eval() / 2;
  }
  int size() const override { return rows_.count(); }
  void apply(const double* x, double* y) const override {
    if (!is_dense_) return rows_.apply(x, y);
    Eigen::Map<Eigen::VectorXd>(y, G_.rows()).noalias() = G_ * Eigen::Map<const Eigen::VectorXd>(x, G_.cols());
  }
  void diagonal_block(const Cone& cone, double* out) const override {
    const int n = cone.size();
    if (!is_dense_) return rows_.block(cone.first, n, out);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) out[i * n + j] = G_(cone.first + i, cone.first + j);
    }
  }
  const Eigen::MatrixXd* dense() const override { return is_dense_ ? &G_ : nullptr; }
  ConeRoot root() const override {
    const WhitenedRows rows = rows_.whitened();
    return {rows.columns, rows.first, rows.column, rows.value};
  }

 private:
  const ContactRows& rows_;
  bool is_dense_ = false;
  Eigen::MatrixXd G_;
  std::vector<double> unit_;
};

TimeStepper::TimeStepper(const Mechanism& mechanism, Dynamics& dynamics, const Loads& loads)
    : mechanism_(mechanism),
      dynamics_(dynamics),
      loads_(loads),
      rows_(dynamics.branching().contact_rows()),
      finder_(mechanism, loads.contacts.size()),
      operator_(std::make_unique<Operator>(rows_)),
      solver_(make_cone_solver(cone_solver_kinds().front().name)),
      v0_(static_cast<std::size_t>(mechanism.nv)),
      v1_(v0_.size()),
      vm_(v0_.size()),
      vdot_(v0_.size()),
      dq_(v0_.size()) {
  state_.forces_along.resize(static_cast<std::size_t>(dynamics.branching().locks()));
  state_.wrenches.resize(mechanism.links.size());
  state_.along.resize(v0_.size());
  state_.sums.resize(loads.contacts.size());
}

TimeStepper::~TimeStepper() = default;

bool TimeStepper::step(double h, const double* u, double* y) {
  double* v = y + mechanism_.nq;
  std::copy_n(v, v0_.size(), v0_.data());
  for (std::size_t k = 0; k < v0_.size(); ++k) dq_[k] = h / 2 * v0_[k];
  dynamics_.displace(y, dq_.data());
  dynamics_.set_position(y);
  dynamics_.factorize();
  dynamics_.readings().set_root_poses();
  dynamics_.set_velocity(v0_.data());
  if (dynamics_.branching().locks() > 0) dynamics_.solve(u, vdot_.data());
  collect(h);
  vm_ = v0_;
  if (!accelerate(h, u)) return false;
  // Once more, with forces at the mean velocity that was found.
  for (std::size_t k = 0; k < v0_.size(); ++k) vm_[k] = (v0_[k] + v1_[k]) / 2;
  if (!accelerate(h, u)) return false;
  for (std::size_t k = 0; k < v1_.size(); ++k) dq_[k] = h / 2 * v1_[k];
  correct_position(h, dq_.data());
  dynamics_.displace(y, dq_.data());
  std::ranges::copy(v1_, v);
  remember(h);
  return all_finite(v1_) && all_finite(dq_);
}

// v1_ <- the velocities at the end of the step, with the forces at vm_.
bool TimeStepper::accelerate(double h, const double* u) {
  dynamics_.set_velocity(vm_.data());
  dynamics_.solve(u, vdot_.data());
  for (std::size_t k = 0; k < v1_.size(); ++k) v1_[k] = v0_[k] + h * vdot_[k];
  if (!all_finite(v1_)) return false;
  if (cones_.empty()) return true;
  set_velocities(h);
  solve_impulses();
  rows_.strike(x_.data(), v1_.data());
  return true;
}

// The rows of all points and locks that may be reached within the step.
void TimeStepper::collect(double h) {
  rows_.clear();
  cones_.clear();
  lock_rows_.clear();
  frames_.clear();
  points_.clear();
  if (!mechanism_.shapes.empty())
    points_ = finder_.find(dynamics_.readings(), h, h * loads_.gravity.norm(), 2 * touch_tolerance);
  for (const TouchPoint& point : points_) add_contact(point);
  add_locks(h);
  const auto n = static_cast<std::size_t>(rows_.count());
  for (std::vector<double>* of : {&b_, &x_, &speeds_, &free_speeds_, &correction_}) of->assign(n, 0.0);
  if (n == 0) return;
  operator_->update();
  rows_.speeds(v0_.data(), speeds_.data());
  set_friction();
  guess(h);
}

void TimeStepper::add_contact(const TouchPoint& point) {
  const ContactLaw& law = loads_.contacts[static_cast<std::size_t>(point.contact)];
  const Cone cone = Cone::contact(rows_.count(), law.static_friction, law.spinning, law.rolling);
  const Eigen::Matrix3d axes = contact_axes(point.normal);
  const int a = mechanism_.shapes[static_cast<std::size_t>(point.a)].link;
  const int b = mechanism_.shapes[static_cast<std::size_t>(point.b)].link;
  rows_.add(a, b, point.p, axes.col(0), false);
  for (int i = 0; i < cone.tangential; ++i) rows_.add(a, b, point.p, axes.col(1 + i), false);
  if (cone.spin > 0) rows_.add(a, b, point.p, axes.col(0), true);
  for (int i = 0; i < cone.roll; ++i) rows_.add(a, b, point.p, axes.col(1 + i), true);
  frames_.push_back(axes);
  cones_.push_back(cone);
}

// What slid in the last step, or strikes with a tangential speed, has sliding friction.
void TimeStepper::set_friction() {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const ContactLaw& law = loads_.contacts[static_cast<std::size_t>(points_[i].contact)];
    if (law.static_friction == law.sliding_friction) continue;
    const RememberedContact* before = state_.find(points_[i]);
    const bool slides = before != nullptr ? before->slides : slip(i, speeds_).norm() > rest_speed;
    if (slides) cones_[i].friction = law.sliding_friction;
  }
}

// The tangential velocity of the second surface relative to the first at a point. speeds: by row.
Eigen::Vector3d TimeStepper::slip(std::size_t point, const std::vector<double>& speeds) const {
  const ContactLaw& law = loads_.contacts[static_cast<std::size_t>(points_[point].contact)];
  const Eigen::Vector3d belt = finder_.pose(points_[point].b).R * law.belt_velocity;
  Eigen::Vector3d out = belt - belt.dot(points_[point].normal) * points_[point].normal;
  const auto first = static_cast<std::size_t>(cones_[point].first) + 1;
  for (int k = 0; k < cones_[point].tangential; ++k) {
    out += frames_[point].col(1 + k) * speeds[first + static_cast<std::size_t>(k)];
  }
  return out;
}

void TimeStepper::add_locks(double h) {
  const Branching& branching = dynamics_.branching();
  for (int i = 0; i < branching.locks(); ++i) {
    const Branching::Lock lock = branching.lock(i);
    const double speed = branching.speed(i, v0_.data());
    if (lock.friction >= 0) {
      const double limit = h * (std::abs(speed) <= rest_speed ? lock.sticking_limit : lock.slipping_limit);
      cones_.push_back(Cone::within(rows_.count(), -limit, limit));
      rows_.add_lock(i, lock.sign);
      lock_rows_.push_back({i, 0, 0});
    }
    if (lock.limit < 0) continue;
    for (const int side : {1, -1}) {
      const double depth = branching.depth(i, side).depth;
      // A bound that other impulses may drive the coordinate to is found in the next step.
      if (!(depth + h * (std::abs(speed) + h * std::abs(branching.speed(i, vdot_.data()))) >= -touch_tolerance))
        continue;
      cones_.push_back(side > 0 ? Cone::within(rows_.count(), -unlimited, 0)
                                : Cone::within(rows_.count(), 0, unlimited));
      rows_.add_lock(i, lock.sign);
      lock_rows_.push_back({i, side, depth});
    }
  }
}

// b_ <- the velocities without impulses, plus those that the laws demand.
void TimeStepper::set_velocities(double h) {
  rows_.speeds(v1_.data(), free_speeds_.data());
  b_ = free_speeds_;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const TouchPoint& point = points_[i];
    const ContactLaw& law = loads_.contacts[static_cast<std::size_t>(point.contact)];
    const auto r = static_cast<std::size_t>(cones_[i].first);
    const bool open = point.gap > touch_tolerance;
    const double approach = std::min(speeds_[r], 0.0);
    const bool strikes = law.restitution > 0 && point.gap + h / 2 * approach <= touch_tolerance;
    b_[r] += strikes ? law.restitution * approach : open ? 2 * point.gap / h : 0;
    if (law.belt_velocity.isZero(0)) continue;
    const Eigen::Vector3d belt = finder_.pose(point.b).R * law.belt_velocity;
    for (int k = 0; k < cones_[i].tangential; ++k)
      b_[r + 1 + static_cast<std::size_t>(k)] += frames_[i].col(1 + k).dot(belt);
  }
  for (std::size_t i = 0; i < lock_rows_.size(); ++i) {
    const Cone& cone = cones_[points_.size() + i];
    set_lock_velocity(lock_rows_[i], static_cast<std::size_t>(cone.first), h);
  }
}

void TimeStepper::set_lock_velocity(const LockRow& row, std::size_t r, double h) {
  if (row.side == 0) return;
  const double approach = std::max(row.side * speeds_[r], 0.0);
  const double restitution = dynamics_.branching().lock(row.lock).restitution;
  const bool strikes = restitution > 0 && row.depth + h / 2 * approach >= -touch_tolerance;
  const double gap = -row.depth;
  b_[r] += row.side * (strikes ? restitution * approach : gap > touch_tolerance ? -2 * gap / h : 0);
}

// x_ <- the impulses of the last step.
void TimeStepper::guess(double h) {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const RememberedContact* before = state_.find(points_[i]);
    if (before == nullptr) continue;
    const Cone& cone = cones_[i];
    double* x = x_.data() + cone.first;
    *x++ = h * frames_[i].col(0).dot(before->force);
    for (int k = 0; k < cone.tangential; ++k) *x++ = h * frames_[i].col(1 + k).dot(before->force);
    if (cone.spin > 0) *x++ = h * frames_[i].col(0).dot(before->moment);
    for (int k = 0; k < cone.roll; ++k) *x++ = h * frames_[i].col(1 + k).dot(before->moment);
  }
  for (std::size_t i = 0; i < lock_rows_.size(); ++i) {
    const Cone& cone = cones_[points_.size() + i];
    const double force = h * state_.forces_along[static_cast<std::size_t>(lock_rows_[i].lock)];
    x_[static_cast<std::size_t>(cone.first)] = std::clamp(force, cone.lower, cone.upper);
  }
}

void TimeStepper::solve_impulses() {
  double fastest = residual_floor;
  for (const double speed : b_) fastest = std::max(fastest, std::abs(speed));
  ConeOptions options;
  options.tolerance = residual_tolerance * fastest;
  options.max_iterations = max_iterations;
  solver_->solve({*operator_, b_, cones_, true}, options, x_.data());
}

// The gap that the first row of a cone changes: of a point or, with the sign of its rate, of a limit; friction has
// none.
TimeStepper::Gap TimeStepper::gap_of(std::size_t cone) const {
  if (cone < points_.size()) return {points_[cone].gap, 1};
  const LockRow& lock = lock_rows_[cone - points_.size()];
  return {-lock.depth, -lock.side};
}

// Adds to dq the smallest displacement that ends all penetrations that remain at the end of the step.
void TimeStepper::correct_position(double h, double* dq) {
  if (cones_.empty()) return;
  rows_.speeds(v1_.data(), free_speeds_.data());
  correction_cones_.clear();
  std::ranges::fill(b_, 0.0);
  std::ranges::fill(correction_, 0.0);
  bool any = false;
  for (std::size_t i = 0; i < cones_.size(); ++i) {
    const int first = cones_[i].first;
    const Gap at = gap_of(i);
    const double gap = at.gap + at.sign * h / 2 * free_speeds_[static_cast<std::size_t>(first)];
    any = any || (at.sign != 0 && gap < -touch_tolerance);
    b_[static_cast<std::size_t>(first)] = at.sign * gap;
    correction_cones_.push_back(Cone::within(first, at.sign < 0 ? -unlimited : 0, at.sign > 0 ? unlimited : 0));
    for (int k = 1; k < cones_[i].size(); ++k) correction_cones_.push_back(Cone::within(first + k, 0, 0));
  }
  if (!any) return;
  ConeOptions options;
  options.tolerance = touch_tolerance / 10;
  options.max_iterations = max_iterations;
  solver_->solve({*operator_, b_, correction_cones_, false}, options, correction_.data());
  rows_.strike(correction_.data(), dq);
}

void TimeStepper::remember(double h) {
  for (Spatial::Force& wrench : state_.wrenches) wrench = {};
  for (ContactSum& contact : state_.sums) contact = {};
  rows_.speeds(v1_.data(), free_speeds_.data());
  state_.contacts.clear();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const TouchPoint& point = points_[i];
    const Cone& cone = cones_[i];
    const double* x = x_.data() + cone.first;
    if (!(x[0] > 0)) continue;
    RememberedContact& contact = state_.contacts.emplace_back();
    contact.a = point.a;
    contact.b = point.b;
    contact.feature = point.feature;
    contact.force = frames_[i].col(0) * (x[0] / h);
    for (int k = 0; k < cone.tangential; ++k) {
      contact.force += frames_[i].col(1 + k) * (x[1 + k] / h);
    }
    contact.slides = cone.tangential == 0 || slip(i, free_speeds_).norm() > rest_speed;
    const double* moment = x + 1 + cone.tangential;
    if (cone.spin > 0) contact.moment += frames_[i].col(0) * (*moment++ / h);
    for (int k = 0; k < cone.roll; ++k) contact.moment += frames_[i].col(1 + k) * (moment[k] / h);
    const Spatial::Force on_b{contact.moment + point.p.cross(contact.force), contact.force};
    state_.wrenches[static_cast<std::size_t>(mechanism_.shapes[static_cast<std::size_t>(point.b)].link)] += on_b;
    state_.wrenches[static_cast<std::size_t>(mechanism_.shapes[static_cast<std::size_t>(point.a)].link)] -= on_b;
    ContactSum& sum = state_.sums[static_cast<std::size_t>(point.contact)];
    sum.force -= mechanism_.X_W0.R * contact.force;
    sum.mode = std::max(sum.mode, contact.slides ? 2 : 1);
  }
  remember_locks(h);
}

void TimeStepper::remember_locks(double h) {
  std::ranges::fill(state_.forces_along, 0.0);
  std::ranges::fill(state_.along, 0.0);
  for (std::size_t i = 0; i < lock_rows_.size(); ++i) {
    const auto r = static_cast<std::size_t>(cones_[points_.size() + i].first);
    state_.forces_along[static_cast<std::size_t>(lock_rows_[i].lock)] += x_[r] / h;
  }
  rows_.add_generalized(static_cast<int>(x_.size()) - static_cast<int>(lock_rows_.size()), x_.data(), 1 / h,
                        state_.along.data());
}

void TimeStepper::forget() {
  state_.contacts.clear();
  std::ranges::fill(state_.forces_along, 0.0);
}

double TimeStepper::gap(int contact) {
  return finder_.smallest_gaps(dynamics_.readings())[static_cast<std::size_t>(contact)];
}

void TimeStepper::serialize(Archive& archive) { state_.serialize(archive, static_cast<int>(mechanism_.shapes.size())); }

}  // namespace gelenk
