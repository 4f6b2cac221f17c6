// SPDX-License-Identifier: BSD-3-Clause
#include "dynamics/dynamics.h"

#include <algorithm>
#include <limits>

#include "derivatives/forward_ad.h"
#include "derivatives/held_branches.h"
#include "derivatives/recursive.h"
#include "derivatives/signal_derivatives.h"
#include "dynamics/joint_modes.h"
#include "dynamics/last_solution.h"
#include "dynamics/law_kinks_of.h"
#include "dynamics/link_inertias.h"
#include "dynamics/mass_factor.h"
#include "dynamics/mass_weighted_jacobian.h"
#include "dynamics/with_kinematics.h"
#include "kinematics/coordinate_kernels.h"
#include "kinematics/coordinate_rows.h"
#include "kinematics/kernels.h"
#include "kinematics/load_kernels.h"
#include "kinematics/output_kernels.h"
#include "kinematics/stages.h"
#include "kinematics/visit.h"
#include "math/bitwise.h"

namespace gelenk {
namespace {

class AllOfDynamics : public Dynamics, public StateReadings {};

template <class A>
class DynamicsOf final : public WithKinematics<A, AllOfDynamics> {
  using Base = WithKinematics<A, AllOfDynamics>;
  using Base::cut_reference_;
  using Base::loads_;
  using Base::mechanism_;
  using Base::model_;
  using Base::q_;
  using Base::targets_;
  using Base::v_;
  using Base::ws_;

 public:
  DynamicsOf(const Mechanism& mechanism, const Loads& loads, bool compute_all_outputs)
      : Base(mechanism, loads),
        added_inertia_(model_.nv),
        compute_all_outputs_(compute_all_outputs),
        all_links_(all_links(mechanism)),
        loaded_links_(links_with_loads(mechanism, loads)),
        M_(model_, ws_, loads.added_inertia, [this](int k) { throw SingularMass(link_moved_by(mechanism_, k)); }),
        Y_(M_, ws_.J, model_.nv),
        modes_({model_, loads_, ws_, q_, v_, cut_reference_}, M_, Y_),
        kinks_({model_, loads_, ws_, q_, v_, cut_reference_}, modes_.laws(), mechanism, *this,
               [this](const double* u) { return this->with_named(u); }),
        max_rank_(model_.rows),
        w_(model_.nv),
        extrapolated_(model_.nv),
        zero_(model_.nv),
        tau_(model_.nv),
        biased_gamma_(model_.rows),
        unlocked_(model_.nv),
        holding_(modes_.locks()),
        last_(loads.inputs, model_.nv, modes_.count(), kinks_.count()) {
    if (!modes_.loads().empty()) zero_rows_.resize(static_cast<std::size_t>(model_.rows));
  }

  void set_position(const double* q) override {
    if (stages_.has(Stage::position) && bitwise_equal(q, q_)) return;
    std::copy(q, q + model_.nq, q_.begin());
    kernels::positions(model_, q, ws_);
    kernels::root_poses(model_, loaded_links_, ws_);
    kernels::loop_positions(model_, ws_);
    kernels::coordinate_row_positions(model_, q, targets_, ws_);
    stages_.realize(Stage::position);
  }

  void set_coordinates(const double* q, const double* v) override {
    stages_.clear();
    ++velocities_;
    std::copy_n(q, model_.nq, q_.begin());
    std::copy_n(v, model_.nv, v_.begin());
  }

  void set_targets(const double* targets) override {
    if (bitwise_equal(targets, targets_)) return;
    stages_.clear();
    std::copy_n(targets, targets_.size(), targets_.begin());
  }

  void factorize() override {
    const bool inertia_unchanged = bitwise_equal(loads_.added_inertia.data(), added_inertia_);
    if (factors_.holds(stages_) && inertia_unchanged) return;
    factors_.drop();
    if (!inertia_unchanged) added_inertia_ = loads_.added_inertia;
    if (model_.rows > 0) fill_jacobian();
    modes_.accelerations_need_mass_factor() ? M_.factorize() : M_.postpone();
    if (model_.rows > 0) Y_.factorize(max_rank_);
    modes_.locked().factors_changed();
    factors_.set(stages_);
  }

  std::string link_without_inertia() override {
    factors_.drop();
    added_inertia_ = loads_.added_inertia;
    const int k = M_.velocity_without_inertia();
    return k < 0 ? std::string{} : link_moved_by(mechanism_, k);
  }

  void set_velocity(const double* v) override {
    const bool changed = !bitwise_equal(v, v_) || gravity_ != loads_.gravity;
    if (!changed && stages_.has(Stage::velocity)) return;
    if (changed) ++velocities_;
    gravity_ = loads_.gravity;
    std::copy(v, v + model_.nv, v_.begin());
    kernels::velocities(model_, q_.data(), v, kernels::root_acceleration<A>(loads_), ws_);
    kernels::loop_velocities(model_, ws_);
    kernels::coordinate_row_velocities(model_, q_.data(), v, targets_, ws_);
    stages_.realize(Stage::velocity);
  }

  void set_singular_threshold(double ratio) override { Y_.set_singular_threshold(ratio); }
  long solution() const override { return last_.number(); }
  void loads_changed() override {
    last_.drop();
    if (!take_inertias(mechanism_, model_)) return;
    stages_.clear();
    factors_.drop();
    forward_ad_.reset();  // has a model of its own
  }

  void solve(const double* given, double* vdot, const double* extrapolated) override {
    const double* const u = this->with_named(given);
    const bool may_repeat = extrapolated == nullptr && depends_on_conditions_alone();
    if (may_repeat && last_.is_for(conditions(u))) {
      ++evaluations_;
      regularized_ = false;
      modes_.set_inputs(u);
      std::ranges::copy(last_.repeat(), vdot);
      if (modes_.locks() > 0) modes_.holding_forces().set(holding_);
      if (std::exchange(link_loads_are_others_, false)) link_loads(u);
      return;
    }
    // Without constraint equations and locks, another solution (with contact forces) overwrites only loads of links.
    const bool keeps_last = model_.rows == 0 && modes_.locks() == 0;
    keeps_last ? last_.begin_other() : last_.drop();
    link_loads_are_others_ = keeps_last && !may_repeat;
    forces(u, w_.data());
    if (modes_.locks() > 0) modes_.set_forces(w_);
    if (extrapolated != nullptr) M_.multiply(extrapolated, extrapolated_.data());
    regularized_ = extrapolated != nullptr;
    if (!modes_.loads().empty()) add_loaded_friction(w_);
    if (model_.rows > 0) M_.add_right_side(biased_gamma(), w_.data());
    find_accelerations(w_.data(), biased_gamma(), regularized_ ? extrapolated_.data() : nullptr);
    std::ranges::copy(w_, vdot);
    if (modes_.locks() > 0) modes_.holding_forces().set(holding_);
    if (may_repeat) last_.keep(conditions(u), w_);
    if (!compute_all_outputs_) return;
    set_root_poses();
    set_acceleration(vdot);
    energy_ = this->energy();
  }

  void set_constraint_bias(const double* bias) override { constraint_bias_ = bias; }

  void assemble(const double* given, double* M, double* f) override {
    const double* const u = this->with_named(given);
    factors_.drop();
    M_.matrix(M);
    if (model_.rows > 0) fill_jacobian();
    forces(u, f);
  }

  void set_root_poses() override { kernels::root_poses(model_, all_links_, ws_); }

  void set_acceleration(const double* vdot) override {
    if (model_.rows > 0) Y_.multipliers(ws_.lambda.data());
    const double* redistribution = modes_.holding_forces().redistribution();
    if (redistribution != nullptr) modes_.locked().add_multipliers(redistribution, ws_.lambda.data());
    kernels::accelerations(model_, vdot, ws_);
  }

  void differentiate(const double* given, int inputs, const double* vdot, Jacobians& out, const double* lambda,
                     bool by_duals) override {
    const double* const u = this->with_named(given);
    if (model_.rows > 0 && lambda == nullptr) Y_.multipliers(ws_.lambda.data());
    if (lambda == nullptr) lambda = ws_.lambda.data();
    const LinearizationPoint at{q_.data(),       v_.data(),        u, vdot, lambda, cut_reference_.data(),
                                targets_.data(), modes_.held(true)};
    const bool has_loads = !modes_.loads().empty();
    const bool relates =
        std::ranges::any_of(model_.coordinate_rows, [](const auto& row) { return row.relation != nullptr; });
    if (!by_duals && !has_loads && !relates && !names_beyond_tree(loads_)) {
      if (!recursive_) recursive_ = std::make_unique<RecursiveJacobians<A>>(model_, ws_, loads_);
      const bool of_inputs = out.of_inputs;
      const int coordinates = static_cast<int>(loads_.named.size());
      out.of_inputs = of_inputs || loads_.states() > 0 || coordinates > 0;
      (*recursive_)(at, coordinates > 0 ? loads_.first_named() + coordinates : inputs, out);
      differentiate_states(loads_, u, out);
      fold_coordinates(loads_, out);
      out.of_inputs = of_inputs;
    } else {
      if (!forward_ad_) forward_ad_ = std::make_unique<Differentiator>(mechanism_, loads_, inputs);
      forward_ad_->hold(has_loads ? modes_.held() : nullptr);
      (*forward_ad_)(at, out);
    }
    if (modes_.held() != nullptr && !has_loads) differentiate_held(loads_, modes_.held(), q_.data(), v_.data(), u, out);
  }

  void solve_linear(double* r, const double* c, double* l, double* holding) const override {
    const bool slips = !modes_.loads().slipping().empty();
    if (slips && l == nullptr) l = modes_.loads().scratch();
    solve_unloaded(r, c, l, holding);
    if (slips) modes_.loads().complete(r, l, holding);
  }

  void solve_linear_columns(double* r, const double* c, int columns) const override {
    if (!modes_.loads().slipping().empty()) {
      const auto solve = [this](double* of, const double* rows) { solve_linear(of, rows, nullptr, nullptr); };
      return modes_.loads().solve_columns(r, c, columns, solve);
    }
    if (model_.rows > 0) M_.add_right_side(c, r, columns);
    const bool locks = modes_.locks_any();
    if (locks && modes_.locked().solve_tree(r, columns)) return;
    M_.solve_transposed(r, columns);
    if (model_.rows > 0) Y_.solve_constrained(r, c, columns, regularized_);
    if (locks) modes_.locked().stop(r, columns);
    M_.solve(r, columns);
    // Exactly 0 also in an implicit method's iterations, lest a coordinate at rest on the bound of a stop cross it.
    if (locks) modes_.locked().clear(r, columns);
  }

  const std::vector<double>& lambda() const override { return ws_.lambda; }
  Eigen::Map<const RowMatrix> J() const override {
    ws_.J.write(J_, model_.nv);
    return {J_.data(), model_.rows, model_.nv};
  }
  const SparseRows& rows_of_J() override { return model_.rows > 0 ? fill_jacobian() : ws_.J; }
  StateReadings& readings() override { return *this; }
  const StateReadings& readings() const override { return *this; }
  SwitchingForces& switching_forces() override { return modes_; }
  LawKinks& kinks() override { return kinks_; }
  int rank() const override { return Y_.rank(); }
  double pivot_ratio() const override { return Y_.rank() < max_rank_ ? 0 : Y_.pivot_ratio(); }
  void set_max_rank(int rank) override {
    if (rank != max_rank_) factors_.drop();
    max_rank_ = rank;
  }

  void min_norm_displacement(const double* residual, double* dv) const override {
    Y_.min_norm(residual, dv);
    for (int k = 0; k < model_.nv; ++k) dv[k] = -dv[k];
    const bool locks = modes_.locks_any();
    if (locks) modes_.locked().stop(dv);
    M_.solve(dv);
    if (locks) modes_.locked().clear(dv);
  }

  void set_cut_reference(const double* q) override {
    if (bitwise_equal(q, cut_reference_)) return;
    std::copy(q, q + model_.cut_nq, cut_reference_.begin());
    last_.drop();
  }
  const double* all_signals(const double* u) override { return this->with_named(u); }
  void set_multipliers(const double* lambda) override {
    std::copy(lambda, lambda + model_.rows, ws_.lambda.begin());
    kernels::constraint_wrenches(model_, ws_);
  }
  Spatial::Motion link_bias_acceleration(int link) const override { return kernels::motion3<A>(ws_.A_bias[link]); }
  long evaluations() const override { return evaluations_; }
  void count_evaluations(long others) override { evaluations_ += others; }

 private:
  // solve_linear() without the effect on friction that depends on loads.
  void solve_unloaded(double* r, const double* c, double* l, double* holding) const {
    if (model_.rows > 0) M_.add_right_side(c, r);
    last_.drop();
    // The derivative of the extrapolated acceleration is zero: it is a constant here.
    const bool locks = find_accelerations(r, c, regularized_ ? zero_.data() : nullptr);
    if (model_.rows > 0 && l != nullptr) Y_.multipliers(l);
    if (locks && holding != nullptr) modes_.holding_forces().in_users_signs(holding_, holding);
  }
  // Adds the friction in motion that depends on loads to the generalized forces f.
  void add_loaded_friction(std::vector<double>& f) {
    const auto free = [&](double* vdot, double* lambda) {
      std::ranges::copy(f, vdot);
      if (model_.rows > 0) M_.add_right_side(biased_gamma(), vdot);
      find_accelerations(vdot, biased_gamma(), regularized_ ? extrapolated_.data() : nullptr);
      if (model_.rows > 0) Y_.multipliers(lambda);
    };
    const auto unit = [&](double* r, double* lambda, double* holding) {
      solve_unloaded(r, zero_rows_.data(), lambda, holding);
    };
    modes_.add_loaded_friction(f, free, unit);
    this->loaded_friction_ = modes_.loads().torque();
  }

  const SparseRows& fill_jacobian() {
    if (jacobian_.holds(stages_)) return ws_.J;
    kernels::loop_jacobian(model_, ws_, ws_.J);
    kernels::coordinate_row_jacobian(model_, ws_);
    jacobian_.set(stages_);
    return ws_.J;
  }

  // Solves the equations for vdot, given the generalized forces f in its place. Returns whether coordinates are locked;
  // their forces are then in holding_.
  bool find_accelerations(double* f, const double* gamma, const double* extrapolated) const {
    const bool locks = modes_.locks() > 0 && modes_.locks_any();
    if (locks && modes_.locked().solve_tree(f, holding_.data())) return true;
    if (locks) {
      std::copy_n(f, model_.nv, unlocked_.begin());
      project(unlocked_.data(), gamma, extrapolated);
      modes_.locked().forces(unlocked_.data(), holding_.data());
      modes_.locked().add_forces(holding_.data(), f);
    }
    project(f, gamma, extrapolated);
    M_.solve(f);
    if (locks) modes_.locked().clear(f);
    return locks;
  }
  void project(double* f, const double* gamma, const double* extrapolated) const {
    M_.solve_transposed(f);
    if (model_.rows > 0) Y_.solve_constrained(f, gamma, extrapolated);
  }

  // f <- tau - h.
  void forces(const double* u, double* f) {
    ++evaluations_;
    modes_.set_inputs(u);
    link_loads(u);
    kernels::inverse_dynamics_bias(model_, ws_, tau_.data());
    for (int k = 0; k < model_.nv; ++k) f[k] = -tau_[k];
    loads_.tree.add(q_.data(), v_.data(), u, f, modes_.held());
    modes_.contact_rows().add_along(f);
  }

  // Whether solve() depends on nothing but the conditions of LastSolution.
  bool depends_on_conditions_alone() const {
    return !compute_all_outputs_ && constraint_bias_ == nullptr && modes_.loads().empty() &&
           !modes_.contact_rows().has_forces();
  }
  LastSolution::Conditions conditions(const double* u) const {
    const std::size_t modes = modes_.held() == nullptr ? 0 : static_cast<std::size_t>(modes_.count());
    return {modes_.locked().generation(), velocities_, Y_.solutions(), u, {modes_.held(), modes}, kinks_.held()};
  }

  void link_loads(const double* u) {
    const bool none = loads_.only_along_tree && !modes_.contact_rows().has_wrenches();
    if (!none || !link_loads_are_zero_) {
      kernels::link_loads(model_, loads_, u, ws_);
      kernels::cut_loads(model_, loads_, u, cut_reference_.data(), ws_, modes_.held(true));
      modes_.contact_rows().add_wrenches(ws_);
    }
    link_loads_are_zero_ = none;
  }

  // gamma, with the constraint bias if one is set.
  const double* biased_gamma() {
    if (constraint_bias_ == nullptr) return ws_.gamma.data();
    for (int r = 0; r < model_.rows; ++r) biased_gamma_[r] = ws_.gamma[r] + constraint_bias_[r];
    return biased_gamma_.data();
  }

  // The workspace has the position of q_ and targets_, and the velocity of v_ and gravity_. They are reused: a step
  // ends at the state at which outputs are read and the next step begins.
  Stages stages_;
  Computed jacobian_{Stage::position}, factors_{Stage::position};  // valid for any inputs
  bool link_loads_are_zero_ = false;                               // in the workspace
  bool link_loads_are_others_ = false;                             // than those of last_
  std::vector<double> added_inertia_;                              // in the factors, on the diagonal of M
  Eigen::Vector3d gravity_{0, 0, 0};
  long velocities_ = 0;  // how often v_ or gravity_ has changed
  bool compute_all_outputs_;
  std::vector<int> all_links_, loaded_links_;
  MassFactor<A> M_;
  MassWeightedJacobian<A> Y_;
  mutable JointModes<A> modes_;
  LawKinksOf<A> kinks_;
  int max_rank_;
  bool regularized_ = false;  // the last solve() had an extrapolated vdot
  std::vector<double> w_, extrapolated_, zero_, tau_, biased_gamma_, zero_rows_;
  mutable std::vector<double> unlocked_, holding_;  // generalized forces without those of locks; forces of the locks
  mutable LastSolution last_;                       // mutable: linear solutions overwrite its holding forces
  const double* constraint_bias_ = nullptr;
  mutable std::vector<double> J_;  // as last returned
  std::unique_ptr<RecursiveJacobians<A>> recursive_;
  std::unique_ptr<Differentiator> forward_ad_;
  Energy energy_;
  long evaluations_ = 0;
};

}  // namespace

std::unique_ptr<Dynamics> make_dynamics(const Mechanism& mechanism, const Loads& loads, bool compute_all_outputs) {
  if (mechanism.planar) return std::make_unique<DynamicsOf<Planar>>(mechanism, loads, compute_all_outputs);
  return std::make_unique<DynamicsOf<Spatial>>(mechanism, loads, compute_all_outputs);
}

}  // namespace gelenk
