// SPDX-License-Identifier: BSD-3-Clause
// Implementation of Branching: the modes of the forces along joints, and the coordinates that friction and limits lock.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "dynamics/branching.h"
#include "dynamics/contact_rows_of.h"
#include "dynamics/force_size.h"
#include "dynamics/loaded_friction.h"
#include "dynamics/locked_coordinates.h"
#include "kinematics/load_kernels.h"

namespace gelenk {

template <class A>
class JointModes final : public Branching {
 public:
  // The state, as far as modes depend on it. All must outlive it.
  struct State {
    const Model<A>& model;
    const Loads& loads;
    Workspace<A>& ws;
    const std::vector<double>&q, &v, &cut_reference;
  };

  JointModes(const State& state, const MassFactor<A>& M, const MassWeightedJacobian<A>& Y)
      : state_(state),
        M_(M),
        locks_(state.model, state.ws, state.loads.added_inertia, M, Y, find_locks(),
               friction_loads(state.model, state.loads).empty() ? rank_threshold : rank_threshold_with_loads),
        contact_rows_(state.model, state.ws, M, Y, locks_),
        holding_(signs()),
        loaded_(state.model, state.loads, state.ws, static_cast<int>(lock_of_.size())),
        force_size_(state.model, state.loads, state.v, M),
        work_(static_cast<std::size_t>(state.model.nv)) {
    find_inputs();
  }

  // The modes in which forces are held, or null: of the tree and the cuts, or from the first cut on.
  const int* held(bool of_cuts = false) const {
    return held_ == nullptr || !of_cuts ? held_ : held_ + state_.loads.tree.branchings();
  }
  // Whether coordinates are locked; if so, the locks are those of the held modes.
  bool locks_any() {
    if (found_.empty()) return false;
    for (int i = 0; i < locks(); ++i) locks_.lock(i, is_held(found_[i]));
    return locks_.any();
  }
  LockedCoordinates<A>& locked() { return locks_; }
  // Whether accelerations are found with the factor of the mass matrix: not in a tree that is partly at rest.
  bool accelerations_need_mass_factor() { return !locks_any() || !locks_.is_tree(); }
  // Keeps the inputs on which modes depend. u: all inputs of the scene.
  void set_inputs(const double* u) {
    for (const int input : input_numbers_) inputs_[static_cast<std::size_t>(input)] = u[input];
  }
  ContactRowsOf<A>& contact_rows() override { return contact_rows_; }
  LoadedFriction<A>& loads() override { return loaded_; }
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
  int count() const override { return static_cast<int>(lock_of_.size()); }
  void sides(int* sides) const override {
    each([&](const auto& force, const double* q, const double* v) { *sides++ = force.side(q, v); });
  }
  void indicators(const std::vector<double>& holding, const double* vdot, double* g, double* gdot) const override {
    int index = 0;
    each([&](const auto& force, const double* q, const double* v) {
      using Element = std::decay_t<decltype(force.element)>;
      const double at = force.sign * q[force.q];
      const double speed = force.sign * v[force.v];
      const int side = held_ == nullptr ? force.side(q, v) : held_[index];
      const int lock = lock_of_[index];
      if constexpr (Sticks<Element>) {
        const double acceleration = vdot == nullptr ? NAN : this->speed(lock, vdot);
        const DirectedLimit limit = loaded_.at_rest(index, force.element, inputs_.data() + force.input);
        const std::array<double, 2> limits{limit.positive + slack(lock), limit.negative + slack(lock)};
        force.element.indicators(side, speed, acceleration, holding[lock], limits, g, gdot);
        if (is_in_contact(lock)) g[0] = g[1] = -1;  // what leaves a contact has overcome friction
      } else if constexpr (Blocks<Element>) {
        const double adhesion = this->lock(lock).sticking_limit.against(-side) + slack(lock);
        if constexpr (BoundsSpeed<Element>) {
          const double acceleration = vdot == nullptr ? NAN : this->speed(lock, vdot);
          force.element.indicators(side, speed, acceleration, holding[lock], adhesion, g, gdot);
        } else {
          force.element.indicators(side, at, speed, holding[lock], adhesion, g, gdot);
        }
      } else {
        const bool is_known = vdot != nullptr && force.element.needs_acceleration(at);
        force.element.indicators(at, speed, is_known ? acceleration(force, index, vdot) : NAN, g, gdot);
      }
      ++index;
      g += 2;
      gdot += 2;
    });
  }
  bool needs_accelerations() const override {
    bool needs = false;
    each([&](const auto& force, const double* q, const double*) {
      if constexpr (requires { force.element.needs_acceleration(0.0); })
        needs = needs || force.element.needs_acceleration(force.sign * q[force.q]);
    });
    return needs;
  }
  void hold(const int* sides) override { held_ = sides; }

  int locks() const override { return static_cast<int>(found_.size()); }
  Lock lock(int lock) const override {
    Lock out = found_[lock];
    visit_friction(out.friction, [&](const auto& element, const double* u) {
      out.sticking_limit = loaded_.at_rest(out.friction, element, u);
      out.slipping_limit = loaded_.at_first(out.friction, element, u);
    });
    visit(out.limit, [&](const auto& force) {
      if constexpr (Blocks<std::decay_t<decltype(force.element)>>) {
        out.restitution = force.element.restitution;
        out.poisson = force.element.is_poisson();
        out.one_way = BoundsSpeed<std::decay_t<decltype(force.element)>>;
      }
    });
    return out;
  }
  DirectedLimit sliding_limit(int lock, double speed) const override {
    DirectedLimit out;
    visit_friction(found_[lock].friction, [&](const auto& element, const double* u) {
      out = loaded_.in_motion(found_[lock].friction, element, speed, u);
    });
    return out;
  }
  Depth depth(int lock, int side) const override {
    Depth out{-HUGE_VAL, 0};
    const int limit = found_[lock].limit;
    visit(limit, [&](const auto& force) {
      if constexpr (Blocks<std::decay_t<decltype(force.element)>>) {
        const int cut = places_[limit].cut;
        const double q =
            cut < 0 ? state_.q[force.q]
                    : kernels::counted_cut_motion(state_.model, state_.ws, cut, state_.cut_reference.data()).q[force.q];
        out = {force.element.depth(side, force.sign * q), force.element.touch_tolerance(side)};
      }
    });
    return out;
  }
  double speed(int lock, const double* v) const override { return found_[lock].sign * locks_.speed(lock, v); }
  HoldingForces& holding_forces() override { return holding_; }

  void clear(double* v) override {
    if (locks_any()) locks_.clear(v);
  }

  void stop(double* v) override {
    if (!locks_any()) return;
    std::vector<double>& w = work_;
    for (int i = 0; i < 2; ++i) {  // the second time removes the rounding of the first
      M_.multiply(v, w.data());
      locks_.stop(w.data());
      M_.solve(w.data());
      std::ranges::copy(w, v);
      locks_.clear(v);
    }
  }

 private:
  // Of the coordinate of a force, in the user's sign; of a cut joint, that of the last set_acceleration().
  template <class Force>
  double acceleration(const Force& force, int index, const double* vdot) const {
    const int cut = places_[static_cast<std::size_t>(index)].cut;
    if (cut < 0) return force.sign * vdot[force.v];
    const auto at = kernels::counted_cut_motion(state_.model, state_.ws, cut, state_.cut_reference.data());
    double a[max_cut_nv] = {};
    kernels::cut_accelerations<A>(state_.model.cuts[cut], state_.ws, cut, at.q.data(), at.v.data(), a);
    return force.sign * a[force.v];
  }
  // What slips at the present velocities, of the friction that depends on loads; brings its factors up to date.
  const std::vector<typename LoadedFriction<A>::Slipping>& find_slipping() {
    slipping_.clear();
    int index = 0;
    each([&](const auto& force, const double* q, const double* v) {
      if constexpr (Sticks<std::decay_t<decltype(force.element)>>) {
        const int side = held_ == nullptr ? force.side(q, v) : held_[index];
        const double factor = force.element.load_factor(side, force.sign * v[force.v], inputs_.data() + force.input);
        if (loaded_.set_factor(index, factor) && (side == 1 || side == -1)) slipping_.push_back({index, side});
      }
      ++index;
    });
    return slipping_;
  }
  // Adds a multiple of the friction with this index among the forces with modes, in the user's sign, to f.
  void add_along(int force, double size, double* f) const {
    const int lock = lock_of_[static_cast<std::size_t>(force)];
    for (const auto& term : locks_.row(lock)) f[term.v] += found_[lock].sign * size * term.factor;
  }

  // Called by users of Branching alone. Without any forces, more than 0.
  double slack(int lock) const override {
    return slack_fraction * force_size_.value() * locks_.inverse_mobility(lock) + std::numeric_limits<double>::min();
  }

  void distribute_loads(const std::vector<double>& holding) override {
    difference_.resize(holding.size());
    lambda_.assign(static_cast<std::size_t>(state_.model.rows), 0.0);
    holding_.find_difference(holding, difference_);
    locks_.add_multipliers(difference_.data(), lambda_.data());
    loaded_.follow(lambda_.data());
  }

  void compliance(const std::vector<int>& locks, Eigen::MatrixXd& W, Eigen::VectorXd& scale) override {
    const auto size = static_cast<Eigen::Index>(locks.size());
    Eigen::MatrixXd y(state_.model.nv, size);
    Eigen::MatrixXd z(state_.model.nv, size);
    scale.resize(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      locks_.whiten(locks[i], y.col(i).data());
      locks_.permitted_part(y.col(i).data(), z.col(i).data());
      z.col(i) *= found_[locks[i]].sign;
      scale[i] = force_size_.value() * y.col(i).norm();
    }
    W = z.transpose() * z;
  }

  void strike(const std::vector<int>& locks, const Eigen::VectorXd& impulses, double* v) override {
    Eigen::VectorXd y(state_.model.nv);
    Eigen::VectorXd z(state_.model.nv);
    Eigen::VectorXd w = Eigen::VectorXd::Zero(state_.model.nv);
    for (std::size_t i = 0; i < locks.size(); ++i) {
      locks_.whiten(locks[i], y.data());
      locks_.permitted_part(y.data(), z.data());
      w += found_[locks[i]].sign * impulses[static_cast<Eigen::Index>(i)] * z;
    }
    M_.solve(w.data());
    for (Eigen::Index k = 0; k < w.size(); ++k) v[k] += w[k];
  }

  std::span<double> inputs() override { return inputs_; }
  bool is_redundant() const override { return locks_.are_redundant(); }

  // Of coordinates at rest that constraint equations hardly permit to move. Where friction depends on loads, such a one
  // would cause loads, and friction, as large as its lever is small: it holds nothing until it is seen to move.
  static constexpr double rank_threshold = 1e-10;
  static constexpr double rank_threshold_with_loads = 1e-6;
  // Part of the forces that may be rounding: far more than that of some hundred operations.
  static constexpr double slack_fraction = 4e-11;

  bool is_in_contact(int lock) const {
    return held_ != nullptr && found_[lock].limit >= 0 && held_[found_[lock].limit] != 0;
  }
  bool is_held(const Lock& lock) const {
    if (held_ == nullptr) return false;
    return (lock.friction >= 0 && held_[lock.friction] == 0) || (lock.limit >= 0 && held_[lock.limit] != 0);
  }

  // Calls visit(force, q, v) for all forces with modes, with the coordinates and velocities to which they refer.
  template <class Visit>
  void each(Visit visit) const {
    kernels::each_branching(state_.model, state_.loads, state_.ws, state_.q.data(), state_.v.data(),
                            state_.cut_reference.data(), visit);
  }

  // Calls visit(force) for one of the forces with modes, by its index; -1: for none.
  template <class Visit>
  void visit(int force, Visit visit) const {
    if (force < 0) return;
    const Place& at = places_[force];
    int number = 0;
    each_list((at.cut < 0 ? state_.loads.tree : state_.loads.cuts[at.cut]).lists, [&](const auto& list) {
      if constexpr (HasBranches<std::decay_t<decltype(list.front().element)>>) {
        if (number++ == at.list) visit(list[at.index]);
      }
    });
  }

  // Calls visit(element, u) if this force is friction, with its inputs.
  template <class Visit>
  void visit_friction(int force, Visit visit) const {
    this->visit(force, [&](const auto& at) {
      if constexpr (Sticks<std::decay_t<decltype(at.element)>>) visit(at.element, inputs_.data() + at.input);
    });
  }

  const JointLoads& along(int cut) const { return cut < 0 ? state_.loads.tree : state_.loads.cuts[cut]; }
  typename LockedCoordinates<A>::Row row_of(int cut, int velocity) const {
    if (cut < 0) return {{velocity, 1}};
    return turn_of_cut(cut);
  }

  // The rows of all locks; fills found_, lock_of_ and places_.
  std::vector<typename LockedCoordinates<A>::Row> find_locks() {
    std::vector<typename LockedCoordinates<A>::Row> rows;
    // By cut (-1: tree) and velocity. A one-way clutch has a lock of its own, as it may hold the coordinate in one
    // direction where a limit holds it in the other.
    std::map<std::tuple<int, int, bool>, int> lock_at;
    const auto look = [&](const auto& force, int cut) {
      using Element = std::decay_t<decltype(force.element)>;
      lock_of_.push_back(-1);
      if constexpr (Sticks<Element> || Blocks<Element>) {
        const bool is_own = BoundsSpeed<Element> && along(cut).bound_position(force.v);
        const auto [place, is_new] = lock_at.try_emplace({cut, force.v, is_own}, locks());
        if (is_new) {
          found_.emplace_back().sign = force.sign;
          rows.push_back(row_of(cut, force.v));
        }
        lock_of_.back() = place->second;
        (Sticks<Element> ? found_[place->second].friction : found_[place->second].limit) =
            static_cast<int>(lock_of_.size()) - 1;
      }
    };
    const auto look_along = [&](const JointLoads& joints, int cut) {
      int number = 0;
      each_list(joints.lists, [&](const auto& list) {
        if constexpr (HasBranches<std::decay_t<decltype(list.front().element)>>) {
          for (std::size_t i = 0; i < list.size(); ++i) {
            places_.push_back({cut, number, i});
            look(list[i], cut);
          }
          ++number;
        }
      });
    };
    look_along(state_.loads.tree, -1);
    for (int c = 0; c < static_cast<int>(state_.loads.cuts.size()); ++c) look_along(state_.loads.cuts[c], c);
    return rows;
  }

  // Fills input_numbers_, and makes room for all inputs up to the last one that a force has, or would have.
  void find_inputs() {
    int end = 0;
    const auto add = [&](const auto& force) {
      const int own = count_of(own_inputs(force.element));
      for (int i = 0; i < own; ++i) input_numbers_.push_back(force.input + i);
      end = std::max(end, force.input + own);
    };
    state_.loads.tree.each_branching(add);
    for (const JointLoads& on : state_.loads.cuts) on.each_branching(add);
    inputs_.resize(static_cast<std::size_t>(end) + 1);
  }

  // The coordinate of a cut joint, which is a revolute joint in the plane (mechanism/tree.cpp cuts no other joint with
  // friction).
  typename LockedCoordinates<A>::Row turn_of_cut(int cut) const {
    typename LockedCoordinates<A>::Row out;
    for (const auto& [v, factor] : turn_of_cut_joint(state_.model, cut, state_.ws)) out.push_back({v, factor});
    return out;
  }

  std::vector<double> signs() const {
    std::vector<double> out;
    for (const Lock& lock : found_) out.push_back(lock.sign);
    return out;
  }

  State state_;
  const MassFactor<A>& M_;
  const int* held_ = nullptr;
  struct Place {
    int cut, list;  // -1: the tree; number among the lists of forces with modes
    std::size_t index;
  };
  std::vector<Place> places_;  // by force with modes
  std::vector<Lock> found_;
  std::vector<int> lock_of_;  // by force with modes; -1: it cannot lock
  LockedCoordinates<A> locks_;
  ContactRowsOf<A> contact_rows_;
  HoldingForces holding_;
  LoadedFriction<A> loaded_;
  std::vector<typename LoadedFriction<A>::Slipping> slipping_;
  std::vector<int> input_numbers_;  // of the inputs that forces with modes have
  std::vector<double> inputs_;      // by number
  ForceSize<A> force_size_;         // of the last solve()
  std::vector<double> work_, difference_, lambda_;
};

}  // namespace gelenk
