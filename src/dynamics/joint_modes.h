// SPDX-License-Identifier: BSD-3-Clause
// Implementation of SwitchingForces: the modes of the forces along joints, and the coordinates that friction and limits
// lock.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "dynamics/contact_rows_of.h"
#include "dynamics/force_size.h"
#include "dynamics/joint_laws.h"
#include "dynamics/loaded_friction.h"
#include "dynamics/locked_coordinates.h"
#include "dynamics/switching_forces.h"
#include "kinematics/load_kernels.h"

namespace gelenk {

template <class A>
class JointModes final : public SwitchingForces {
 public:
  using State = typename JointLaws<A>::State;

  // All must outlive it.
  JointModes(const State& state, const MassFactor<A>& M, const MassWeightedJacobian<A>& Y)
      : state_(state),
        laws_(state),
        M_(M),
        locks_(state.model, state.ws, state.loads.added_inertia, M, Y, laws_.rows(),
               friction_loads(state.model, state.loads).empty() ? rank_threshold : rank_threshold_with_loads),
        contact_rows_(state.model, state.ws, M, Y, locks_),
        holding_(laws_.signs()),
        loaded_(state.model, state.loads, state.ws, laws_.count(), laws_.all_inputs()),
        force_size_(state.model, state.loads, state.v, M),
        work_(static_cast<std::size_t>(state.model.nv)) {}

  // The modes in which forces are held, or null: of the tree and the cuts, or from the first cut on.
  const int* held(bool of_cuts = false) const {
    return held_ == nullptr || !of_cuts ? held_ : held_ + state_.loads.tree.switching_count();
  }
  // Whether coordinates are locked; if so, the locks are those of the held modes.
  bool locks_any() {
    if (locks() == 0) return false;
    for (int i = 0; i < locks(); ++i) locks_.lock(i, is_held(laws_.lock(i)));
    return locks_.any();
  }
  LockedCoordinates<A>& locked() { return locks_; }
  // Whether accelerations are found with the factor of the mass matrix: not in a tree that is partly at rest.
  bool accelerations_need_mass_factor() { return !locks_any() || !locks_.is_tree(); }
  // Keeps the inputs on which modes depend. u: all inputs of the scene.
  void set_inputs(const double* u) { laws_.set_inputs(u); }
  ContactRowsOf<A>& contact_rows() override { return contact_rows_; }
  LoadedFriction<A>& loads() override { return loaded_; }
  const JointLaws<A>& laws() const { return laws_; }
  // Adds the friction in motion that depends on loads to the generalized forces f. free(vdot, lambda): the solution of
  // the equations of motion with f alone; unit(f, lambda, holding): with the generalized forces f, overwritten by vdot,
  // alone.
  template <class Free, class Unit>
  void add_loaded_friction(std::vector<double>& f, Free free, Unit unit) {
    loaded_.solve(find_slipping(), [&](int friction, std::vector<double>& vdot, std::vector<double>& lambda,
                                       std::vector<double>& holding) {
      vdot.assign(f.size(), 0.0);
      lambda.resize(static_cast<std::size_t>(state_.model.rows));
      holding.assign(static_cast<std::size_t>(locks()), 0.0);
      if (friction < 0) return free(vdot.data(), lambda.data());
      add_along(friction, 1, vdot.data());
      unit(vdot.data(), lambda.data(), holding.data());
    });
    for (const auto& slips : loaded_.slipping())
      add_along(slips.force, loaded_.torque()[static_cast<std::size_t>(slips.force)], f.data());
  }
  // Keeps the generalized forces f of a solve().
  void set_forces(const std::vector<double>& f) {
    force_size_.set(f);
    if (!loaded_.empty()) loaded_.set_force_size(force_size_.value());
  }
  int count() const override { return laws_.count(); }
  void sides(int* sides) const override {
    laws_.each([&](const auto& force, const double* q, const double* v) { *sides++ = force.side(q, v); });
  }
  void indicators(const std::vector<double>& holding, const double* vdot, double* g, double* gdot) const override {
    int index = 0;
    laws_.each([&](const auto& force, const double* q, const double* v) {
      using Element = std::decay_t<decltype(force.element)>;
      const double at = force.sign * q[force.q];
      const double speed = force.sign * v[force.v];
      const int side = held_ == nullptr ? force.side(q, v) : held_[index];
      const int lock = laws_.lock_of(index);
      if constexpr (Sticks<Element>) {
        const double acceleration = vdot == nullptr ? NAN : this->speed(lock, vdot);
        const DirectedLimit limit = sticking_limit(lock);
        const std::array<double, 2> limits{limit.positive + slack(lock), limit.negative + slack(lock)};
        force.element.indicators(side, speed, acceleration, holding[lock], limits, g, gdot);
      } else if constexpr (HoldsJoint<Element>) {
        g[0] = laws_.engagement(index);
        g[1] = -1;
        gdot[0] = gdot[1] = NAN;
      } else if constexpr (Blocks<Element>) {
        const double adhesion = sticking_limit(lock).against(-side) + slack(lock);
        if constexpr (BoundsSpeed<Element>) {
          const double acceleration = vdot == nullptr ? NAN : this->speed(lock, vdot);
          force.element.indicators(side, speed, acceleration, holding[lock], adhesion, g, gdot);
        } else {
          force.element.indicators(side, at, speed, holding[lock], adhesion, g, gdot);
        }
      } else {
        const bool is_known = vdot != nullptr && force.element.needs_acceleration(at);
        force.element.indicators(at, speed, is_known ? laws_.acceleration(force, index, vdot) : NAN, g, gdot);
      }
      if (has_nothing_to_hold<Element>(lock)) g[0] = g[1] = -1;
      ++index;
      g += 2;
      gdot += 2;
    });
  }
  void hold(const int* sides) override { held_ = sides; }
  const int* held_modes() const override { return held_; }

  int locks() const override { return laws_.locks(); }
  const Lock& lock(int lock) const override { return laws_.lock(lock); }
  DirectedLimit sliding_limit(int lock, double speed) const override {
    return sum_of_friction(lock, [&](int i, const auto& law, double q, const double* u) {
      return loaded_.in_motion(i, law, q, speed, u);
    });
  }
  double part_of_friction(int friction, int motion) const override {
    const int lock = laws_.lock_of(friction);
    const double speed = this->speed(lock, state_.v.data());
    const auto size = [&](int of) {
      double out = 0;
      laws_.visit_friction(of, [&](const auto& law, double q, const double* u) {
        const DirectedLimit limit =
            motion == 0 ? loaded_.at_rest(of, law, q, u) : loaded_.in_motion(of, law, q, speed, u);
        out = limit.largest();
      });
      return out;
    };
    double sum = 0;
    for (const int of : laws_.lock(lock).frictions) sum += size(of);
    return sum > 0 ? size(friction) / sum : 1.0 / static_cast<double>(laws_.lock(lock).frictions.size());
  }
  Depth depth(int lock, int side) const override {
    Depth out{-HUGE_VAL, 0};
    const int limit = laws_.lock(lock).limit;
    laws_.visit(limit, [&](const auto& force) {
      if constexpr (Blocks<std::decay_t<decltype(force.element)>>) {
        out = {force.element.depth(side, laws_.position(force, limit)), force.element.touch_tolerance(side),
               force.element.restitution};
      }
    });
    return out;
  }
  double speed(int lock, const double* v) const override { return laws_.lock(lock).sign * locks_.speed(lock, v); }
  HoldingForces& holding_forces() override { return holding_; }

  void clear(double* v) override {
    if (locks_any()) locks_.clear(v);
  }

  bool stop(double* v) override {
    bool stops_all = true;
    if (!locks_any()) return stops_all;
    std::vector<double>& w = work_;
    for (int i = 0; i < 2; ++i) {  // the second time removes the rounding of the first
      M_.multiply(v, w.data());
      stops_all = locks_.stop_rounding(w.data()) && stops_all;
      M_.solve(w.data());
      std::ranges::copy(w, v);
      if (stops_all) locks_.clear(v);
    }
    return stops_all;
  }

 private:
  // Adds limit(index, law, q, u) of the laws of friction of a lock.
  template <class LimitOf>
  DirectedLimit sum_of_friction(int lock, LimitOf limit) const {
    const std::vector<int>& frictions = laws_.lock(lock).frictions;
    DirectedLimit out{.vanishes = !frictions.empty()};
    for (const int i : frictions)
      laws_.visit_friction(i, [&](const auto& law, double q, const double* u) { out += limit(i, law, q, u); });
    return out;
  }
  // What slips at the present velocities, of the friction that depends on loads; brings its factors up to date.
  const std::vector<typename LoadedFriction<A>::Slipping>& find_slipping() {
    slipping_.clear();
    int index = 0;
    laws_.each([&](const auto& force, const double* q, const double* v) {
      if constexpr (TakesLoads<std::decay_t<decltype(force.element)>>) {
        const int side = held_ == nullptr ? force.side(q, v) : held_[index];
        const double speed = force.sign * v[force.v];
        const double factor = force.with_inputs(
            laws_.all_inputs(), [&](const double* u) { return force.element.load_factor(side, speed, u); });
        const bool has_loads = loaded_.set_factor(index, factor, speed);
        if (has_loads && (side == 1 || side == -1)) slipping_.push_back({index, side});
      }
      ++index;
    });
    return slipping_;
  }
  // Adds a multiple of the friction with this index among the forces with modes, in the user's sign, to f.
  void add_along(int force, double size, double* f) const {
    const int lock = laws_.lock_of(force);
    for (const auto& term : locks_.row(lock)) f[term.v] += laws_.lock(lock).sign * size * term.factor;
  }

  // These are called by users of SwitchingForces alone.
  bool needs_accelerations() const override {
    bool needs = false;
    laws_.each([&](const auto& force, const double* q, const double*) {
      if constexpr (requires { force.element.needs_acceleration(0.0); })
        needs = needs || force.element.needs_acceleration(force.sign * q[force.q]);
    });
    return needs;
  }
  DirectedLimit sticking_limit(int lock) const override {
    return sum_of_friction(
        lock, [&](int i, const auto& law, double q, const double* u) { return loaded_.at_rest(i, law, q, u); });
  }
  DirectedLimit slipping_limit(int lock) const override {
    return sum_of_friction(
        lock, [&](int i, const auto& law, double q, const double* u) { return loaded_.at_first(i, law, q, u); });
  }
  // Without any forces, more than 0.
  double slack(int lock) const override {
    return slack_fraction * force_size_.value() * locks_.inverse_mobility(lock) + std::numeric_limits<double>::min();
  }

  double largest_force(int lock) const override { return force_size_.value() * locks_.inverse_mobility(lock, true); }
  void distribute_loads(const std::vector<double>& holding) override {
    difference_.resize(holding.size());
    lambda_.assign(static_cast<std::size_t>(state_.model.rows), 0.0);
    holding_.find_difference(holding, difference_);
    locks_.add_multipliers(difference_.data(), lambda_.data());
    loaded_.follow(lambda_.data());
  }

  void compliance(const std::vector<int>& locks, Eigen::MatrixXd& W, Eigen::VectorXd& scale) override {
    const auto size = static_cast<Eigen::Index>(locks.size());
    find_latched_beside(locks);
    if (compliance_of_ != locks || compliance_generation_ != locks_.generation() || latched_before_ != latched_) {
      whitened_.resize(state_.model.nv);
      permitted_.resize(state_.model.nv, size);
      sizes_.resize(size);
      for (Eigen::Index i = 0; i < size; ++i) {
        locks_.whiten(locks[i], whitened_.data());
        locks_.permitted_part(whitened_.data(), permitted_.col(i).data());
        permitted_.col(i) *= laws_.lock(locks[i]).sign;
        sizes_[i] = whitened_.norm();
      }
      if (!latched_.empty()) {
        const Eigen::MatrixXd latched = motion_of_latched();
        for (Eigen::Index i = 0; i < size; ++i) {
          leave_at_rest(latched, permitted_.col(i));
          if (!(permitted_.col(i).norm() > rank_threshold * sizes_[i])) permitted_.col(i).setZero();
        }
      }
      compliance_.noalias() = permitted_.transpose() * permitted_;
      compliance_of_ = locks;
      latched_before_ = latched_;
      compliance_generation_ = locks_.generation();
    }
    W = compliance_;
    scale = force_size_.value() * sizes_;
  }

  void strike(const std::vector<int>& locks, const Eigen::VectorXd& impulses, double* v) override {
    Eigen::VectorXd y(state_.model.nv);
    Eigen::VectorXd z(state_.model.nv);
    Eigen::VectorXd w = Eigen::VectorXd::Zero(state_.model.nv);
    for (std::size_t i = 0; i < locks.size(); ++i) {
      locks_.whiten(locks[i], y.data());
      locks_.permitted_part(y.data(), z.data());
      w += laws_.lock(locks[i]).sign * impulses[static_cast<Eigen::Index>(i)] * z;
    }
    find_latched_beside(locks);
    if (!latched_.empty()) leave_at_rest(motion_of_latched(), w);
    M_.solve(w.data());
    for (Eigen::Index k = 0; k < w.size(); ++k) v[k] += w[k];
  }

  std::span<double> inputs() override { return laws_.inputs(); }
  bool is_redundant() const override { return locks_.are_redundant(); }

  // Of coordinates at rest that constraint equations hardly permit to move. Where friction depends on loads, such a one
  // would cause loads, and friction, as large as its lever is small: it holds nothing until it is seen to move.
  static constexpr double rank_threshold = 1e-10;
  static constexpr double rank_threshold_with_loads = 1e-6;
  // Part of the forces that may be rounding: far more than that of some hundred operations.
  static constexpr double slack_fraction = 4e-11;

  bool is_in_contact(int lock) const {
    return held_ != nullptr && laws_.lock(lock).limit >= 0 && held_[laws_.lock(lock).limit] != 0;
  }
  bool is_held(const Lock& lock) const {
    if (held_ == nullptr) return false;
    return (lock.friction >= 0 && held_[lock.friction] == 0) || (lock.limit >= 0 && held_[lock.limit] != 0) ||
           (lock.latch >= 0 && held_[lock.latch] == 1);
  }
  bool hold_coordinate(int lock) const override {
    const int latch = held_ == nullptr ? -1 : laws_.latch_over(lock);
    return latch >= 0 && held_[latch] == 1;
  }
  double engagement(int lock) const override { return laws_.engagement(laws_.latch_over(lock)); }
  // What leaves a contact has overcome friction; and a latch leaves friction and limits nothing to hold.
  template <class Element>
  bool has_nothing_to_hold(int lock) const {
    if constexpr (Sticks<Element>) return is_in_contact(lock) || hold_coordinate(lock);
    if constexpr (Blocks<Element>) return hold_coordinate(lock);
    return false;
  }
  // Into latched_: the locks that a latch holds, and that are not among these.
  void find_latched_beside(const std::vector<int>& locks) {
    latched_.clear();
    for (int i = 0; i < laws_.locks(); ++i) {
      const int latch = laws_.lock(i).latch;
      if (latch >= 0 && hold_coordinate(i) && std::ranges::find(locks, i) == locks.end()) latched_.push_back(i);
    }
  }
  // Orthonormal columns that span what moves latched_, whitened.
  Eigen::MatrixXd motion_of_latched() const {
    Eigen::MatrixXd out(state_.model.nv, 0);
    Eigen::VectorXd y(state_.model.nv), z(state_.model.nv);
    for (const int latched : latched_) {
      locks_.whiten(latched, y.data());
      if (!(locks_.permitted_part(y.data(), z.data()) > 0)) continue;
      leave_at_rest(out, z);
      if (!(z.norm() > rank_threshold * y.norm())) continue;  // others determine it
      out.conservativeResize(Eigen::NoChange, out.cols() + 1);
      out.rightCols(1) = z.normalized();
    }
    return out;
  }
  // z <- its part that moves none of these.
  static void leave_at_rest(const Eigen::MatrixXd& latched, Eigen::Ref<Eigen::VectorXd> z) {
    for (int twice = 0; twice < 2; ++twice) z -= latched * (latched.transpose() * z).eval();  // once leaves rounding
  }

  State state_;
  JointLaws<A> laws_;
  const MassFactor<A>& M_;
  const int* held_ = nullptr;
  LockedCoordinates<A> locks_;
  ContactRowsOf<A> contact_rows_;
  HoldingForces holding_;
  LoadedFriction<A> loaded_;
  std::vector<typename LoadedFriction<A>::Slipping> slipping_;
  ForceSize<A> force_size_;  // of the last solve()
  std::vector<double> work_, difference_, lambda_;
  // Of compliance(), which mechanisms at rest are asked for again and again.
  std::vector<int> compliance_of_, latched_, latched_before_;
  long compliance_generation_ = -1;
  Eigen::VectorXd whitened_, sizes_;
  Eigen::MatrixXd permitted_, compliance_;
};

}  // namespace gelenk
