// SPDX-License-Identifier: BSD-3-Clause
// Friction that depends on forces of the mechanism which depend on it. With the friction T of what slips, the equations
// of motion are linear, and so are the forces that it is proportional to,
//   rho = rho0 + K T,     T_j = -sigma_j sum of k_l |rho_l|,
// sigma_j the direction of motion; the second are a few equations with kinks, which Newton's method solves. K costs one
// solution of the equations of motion for each friction that slips. For small coefficients T is unique; for larger ones
// there may be none or several (Painleve).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "dynamics/load_dependence.h"
#include "dynamics/switching_forces.h"
#include "dynamics/transmitted_load.h"
#include "kinematics/friction_loads.h"
#include "linear/dense_factor.h"
#include "math/dual.h"

namespace gelenk {

template <class A>
class LoadedFriction final : public LoadDependence {
 public:
  // What slips against friction that depends on loads.
  struct Slipping {
    int force;      // among all forces with modes
    int direction;  // in the user's sign
  };
  using Load = TransmittedLoad;

  // signals: all, on which losses depend; must outlive it.
  LoadedFriction(const Model<A>& model, const Loads& loads, const Workspace<A>& ws, int forces, const double* signals)
      : model_(model), of_scene_(loads), ws_(ws), signals_(signals), torque_(static_cast<std::size_t>(forces)) {
    for (const FrictionLoad& load : friction_loads(model, loads)) {
      loads_.push_back({load});
      const bool is_planar_guide = A::planar && load.of == FrictionLoad::Of::guide;
      loads_.back().has_sign = load.of == FrictionLoad::Of::mesh || is_planar_guide;
      loads_.back().has_curved_losses =
          load.of == FrictionLoad::Of::mesh && loads.losses[static_cast<std::size_t>(load.row)].depend_on_load();
    }
    for (const Load& load : loads_) {
      if (std::ranges::find(owners_, load.is.force) == owners_.end()) owners_.push_back(load.is.force);
    }
    const std::size_t n = owners_.size();
    for (auto* of : {&responses_, &multipliers_, &holding_}) of->resize(n);
    K_.resize(n * loads_.size());
    matrix_.resize(n * n);
    pivots_.resize(n);
    rest_.resize(n);
  }

  bool empty() const override { return loads_.empty(); }
  bool acts_on(int force) const override { return std::ranges::find(owners_, force) != owners_.end(); }
  int signed_count() const override { return static_cast<int>(std::ranges::count_if(loads_, &Load::has_sign)); }
  void indicators(double* g) const override {
    for (const Load& load : loads_) {
      if (load.has_sign) *g++ = load.force[0] + load.known_sign() * (load_rounding * force_size_ + least_load);
    }
  }
  void hold_signs(const bool* positive) override {
    for (Load& load : loads_) {
      if (load.has_sign) load.held_sign = positive == nullptr ? 0 : *positive++ ? 1 : -1;
    }
  }
  // |L^-T f| for the present forces f, to which rounding is relative.
  void set_force_size(double size) { force_size_ = size; }
  // Sets what the friction with this index is per size of the load of its bearing, and at this speed of its mesh;
  // returns whether it has loads.
  bool set_factor(int force, double factor, double speed) {
    bool any = false;
    for (Load& load : loads_) {
      if (load.is.force != force) continue;
      load.factor = factor;
      load.speed = speed;
      load.losses = load.derivatives = losses(load, speed);
      any = true;
    }
    return any;
  }
  // What the friction with this index can exert at this speed: without loads, and per size of the load of a
  // bearing.
  DirectedLimit limit(int force, double speed, double without, double of_bearing) const {
    DirectedLimit out{.positive = without, .negative = without, .vanishes = without == 0 && of_bearing == 0};
    if (!loads_.empty()) add_loads(force, speed, of_bearing, out);
    return out;
  }
  // What it can exert at rest, in a motion that begins, and in motion at this speed. friction: the law with this index;
  // q: its coordinate, u: its inputs.
  template <class Friction>
  DirectedLimit at_rest(int force, const Friction& friction, double q, const double* u) const {
    double of_bearing = 0;
    if constexpr (TakesLoads<Friction>) of_bearing = friction.sticking_load_factor(u);
    return limit(force, 0, friction.sticking_limit(q, u), of_bearing);
  }
  template <class Friction>
  DirectedLimit at_first(int force, const Friction& friction, double q, const double* u) const {
    double of_bearing = 0;
    if constexpr (TakesLoads<Friction>) of_bearing = friction.slipping_load_factor(u);
    return limit(force, 0, friction.slipping_limit(q, u), of_bearing);
  }
  template <class Friction>
  DirectedLimit in_motion(int force, const Friction& friction, double q, double speed, const double* u) const {
    const int side = speed < 0 ? -1 : 1;
    double of_bearing = 0;
    if constexpr (TakesLoads<Friction>) of_bearing = friction.load_factor(side, speed, u);
    return limit(force, speed, friction.friction(side, q, speed, u), of_bearing);
  }
  // By force with modes: the friction in motion due to loads, in the user's sign.
  const std::vector<double>& torque() const { return torque_; }
  void freeze(bool on) override { is_frozen_ = on; }
  int undetermined() const override { return undetermined_; }
  void set_undetermined() override { undetermined_ = loads_.front().is.force; }
  int seized() const override { return seized_; }
  int unloaded() const override {
    for (const Slipping& slips : slipping_) {
      for (const Load& load : loads_) {
        if (load.has_sign && is_zero(load) && load.is.force == slips.force) return slips.force;
      }
    }
    return -1;
  }
  const std::vector<Slipping>& slipping() const { return slipping_; }

  // Finds the friction T of what slips and the loads. respond(force, vdot, lambda, holding): the response of the
  // mechanism to a unit of the friction with this index alone, in the user's sign; -1: to everything else.
  template <class Respond>
  void solve(const std::vector<Slipping>& slipping, Respond respond) {
    slipping_ = slipping;
    undetermined_ = seized_ = -1;
    if (is_frozen_) return;
    respond(-1, vdot_, lambda_, unused_);
    kernels::wrenches_of(model_, ws_, vdot_.data(), lambda_.data(), false, wrenches_);
    for (Load& load : loads_) load.without_friction = load.force = transmitted(load, lambda_.data());
    for (std::size_t j = 0; j < slipping_.size(); ++j) {
      respond(slipping_[j].force, responses_[j], multipliers_[j], holding_[j]);
      kernels::wrenches_of(model_, ws_, responses_[j].data(), multipliers_[j].data(), true, wrenches_);
      for (std::size_t l = 0; l < loads_.size(); ++l) K(l, j) = transmitted(loads_[l], multipliers_[j].data());
    }
    std::ranges::fill(torque_, 0.0);
    choose_signs_of_none();
    if (!slipping_.empty()) {
      const Outcome outcome = iterate(1);
      if (outcome != Outcome::found) look_further(outcome);
    }
    for (Load& load : loads_) load.solved = load.force;
  }

  // Brings the loads of what does not slip to multipliers that differ by these from those of the last solve().
  void follow(const double* multipliers) {
    vdot_.assign(static_cast<std::size_t>(model_.nv), 0.0);
    kernels::wrenches_of(model_, ws_, vdot_.data(), multipliers, true, wrenches_);
    for (Load& load : loads_) {
      if (std::ranges::find(slipping_, load.is.force, &Slipping::force) != slipping_.end()) continue;
      const std::array<double, 3> change = transmitted(load, multipliers);
      for (std::size_t k = 0; k < 3; ++k) load.force[k] = load.solved[k] + change[k];
    }
  }

  // Room for multipliers.
  double* scratch() {
    multipliers_of_one_.resize(static_cast<std::size_t>(model_.rows));
    return multipliers_of_one_.data();
  }
  int affected_by(const double* multipliers) override {
    vdot_.assign(static_cast<std::size_t>(model_.nv), 0.0);
    kernels::wrenches_of(model_, ws_, vdot_.data(), multipliers, true, wrenches_);
    for (const Load& load : loads_) {
      if (!load.is.may_be_undetermined && size_of_load(transmitted(load, multipliers)) > affecting)
        return load.is.force;
    }
    return -1;
  }

  // The effect of changes of the mechanism on friction, and of these on the mechanism: completes the solution (vdot,
  // lambda, holding) of linearized equations without it.
  void complete(double* vdot, double* lambda, double* holding) {
    if (slipping_.empty() || is_frozen_) return;
    kernels::wrenches_of(model_, ws_, vdot, lambda, true, wrenches_);
    set_matrix();
    for (std::size_t j = 0; j < slipping_.size(); ++j) {
      double sum = 0;
      each_load(j, &Load::derivatives,
                [&](std::size_t l, double factor) { sum += factor * along(l, transmitted(loads_[l], lambda)); });
      rest_[j] = -slipping_[j].direction * sum;
    }
    solve_matrix();
    for (std::size_t j = 0; j < slipping_.size(); ++j) {
      add_to(vdot, responses_[j], rest_[j]);
      add_to(lambda, multipliers_[j], rest_[j]);
      if (holding != nullptr) add_to(holding, holding_[j], rest_[j]);
    }
  }

  // Solves for each column of r (nv x columns) and c (rows x columns), stored row by row, by solve_one(r, c),
  // which calls complete().
  template <class SolveOne>
  void solve_columns(double* r, const double* c, int columns, SolveOne solve_one) {
    const auto n = static_cast<std::size_t>(model_.nv);
    const auto m = static_cast<std::size_t>(model_.rows);
    const auto k = static_cast<std::size_t>(columns);
    column_.resize(n);
    column_rows_.resize(m);
    for (std::size_t j = 0; j < k; ++j) {
      for (std::size_t i = 0; i < n; ++i) column_[i] = r[i * k + j];
      for (std::size_t i = 0; i < m; ++i) column_rows_[i] = c[i * k + j];
      solve_one(column_.data(), column_rows_.data());
      for (std::size_t i = 0; i < n; ++i) r[i * k + j] = column_[i];
    }
  }

 private:
  // Newton's method converges within a few steps, or not at all.
  static constexpr int most_iterations = 60;
  static constexpr int parts = 16;            // of the losses, in which a motion is followed
  static constexpr double tolerance = 4e-16;  // of friction
  static constexpr double rounding = 1e-13;   // what Newton's method may not be able to reduce any more
  static constexpr double least_pivot = 1e-300;
  static constexpr double load_rounding = 1e-13;  // of loads, relative to |L^-T f|
  static constexpr double least_load = 1e-300;    // where nothing acts
  static constexpr double affecting = 1e-8;       // of multipliers of size 1; less is rounding

  // Not inline, so that limits without loads remain short.
  [[gnu::noinline]] void add_loads(int force, double speed, double of_bearing, DirectedLimit& out) const {
    for (const Load& load : loads_) {
      if (load.is.force != force) continue;
      out.vanishes = out.vanishes && load.is.of != FrictionLoad::Of::mesh;
      const std::array<double, 2> of_mesh = losses(load, speed);
      out.positive += load.friction(1, of_mesh, of_bearing);
      out.negative += load.friction(-1, of_mesh, of_bearing);
    }
  }
  std::array<double, 2> losses(const Load& load, double speed) const {
    if (load.is.of != FrictionLoad::Of::mesh) return {};
    return of_scene_.losses[static_cast<std::size_t>(load.is.row)].at(speed, load.size(), signals_);
  }
  // Of meshes whose losses depend on their force, at the present one.
  void update_losses() {
    for (Load& load : loads_) {
      if (!load.has_curved_losses) continue;
      Dual size(load.size());
      size.derivatives()[0] = 1;
      const auto at = of_scene_.losses[static_cast<std::size_t>(load.is.row)].at(Dual(load.speed), size, signals_);
      for (std::size_t k = 0; k < at.size(); ++k) {
        load.losses[k] = at[k].value();
        load.derivatives[k] = at[k].value() + at[k].derivatives()[0] * size.value();
      }
    }
  }
  std::array<double, 3> transmitted(const Load& load, const double* lambda) const {
    return transmitted_force(load.is, model_, ws_, wrenches_.F, lambda);
  }
  std::array<double, 3>& K(std::size_t load, std::size_t slipping) { return K_[load * owners_.size() + slipping]; }
  double& torque_of(std::size_t j) { return torque_[static_cast<std::size_t>(slipping_[j].force)]; }

  // Calls visit(load, friction per size) for the loads of the friction of what slips. of_mesh: that of meshes.
  template <class Visit>
  void each_load(std::size_t j, std::array<double, 2> Load::* of_mesh, Visit visit) const {
    for (std::size_t l = 0; l < loads_.size(); ++l) {
      const Load& load = loads_[l];
      if (load.is.force != slipping_[j].force) continue;
      visit(l, part_ * load.is.friction_per_size(slipping_[j].direction, load.sign(), load.*of_mesh, load.factor));
    }
  }
  // The rate of the size of a load for a change of its force.
  double along(std::size_t l, const std::array<double, 3>& change) const {
    if (loads_[l].has_sign) return loads_[l].sign() * change[0];
    const double size = loads_[l].size();
    if (!(size > 0)) return 0;
    const std::array<double, 3>& f = loads_[l].force;
    return (f[0] * change[0] + f[1] * change[1] + f[2] * change[2]) / size;
  }
  // Adds a change of the friction of what slips.
  void add(std::size_t j, double change) {
    for (std::size_t l = 0; l < loads_.size(); ++l) {
      for (std::size_t k = 0; k < 3; ++k) loads_[l].force[k] += K(l, j)[k] * change;
    }
  }
  bool is_zero(const Load& load) const { return std::abs(load.force[0]) <= load_rounding * force_size_; }
  // Without a load a mesh in motion has no friction, also where it would seize with a load of one sign: it has the
  // other one then, so that the load has to change its sign before.
  void choose_signs_of_none() {
    for (Load& load : loads_) load.sign_of_none = 0;
    for (std::size_t j = 0; j < slipping_.size(); ++j) {
      for (std::size_t l = 0; l < loads_.size(); ++l) {
        Load& load = loads_[l];
        if (load.is.force != slipping_[j].force || !load.has_sign || load.held_sign != 0 || !is_zero(load)) continue;
        const int direction = slipping_[j].direction;
        const auto seizes = [&](int sign) {
          const double factor = load.is.friction_per_size(direction, sign, load.losses, load.factor);
          return 1 + direction * factor * sign * K(l, j)[0] <= 0;
        };
        load.sign_of_none = load.force[0] < 0 ? -1 : 1;
        if (seizes(load.sign_of_none)) load.sign_of_none = -load.sign_of_none;
      }
    }
  }
  // The derivative of the equations of T, factorized. Returns whether its determinant is positive, as it is for small
  // coefficients.
  bool set_matrix() {
    const auto n = static_cast<Eigen::Index>(slipping_.size());
    DenseMatrix of(matrix_.data(), n, n);
    for (Eigen::Index j = 0; j < n; ++j) {
      for (Eigen::Index i = 0; i < n; ++i) {
        double sum = 0;
        each_load(static_cast<std::size_t>(j), &Load::derivatives,
                  [&](std::size_t l, double factor) { sum += factor * along(l, K(l, static_cast<std::size_t>(i))); });
        of(j, i) = (i == j ? 1 : 0) + slipping_[static_cast<std::size_t>(j)].direction * sum;
      }
    }
    factorize_general(of, pivots_.data(), least_pivot);
    return has_positive_determinant(of, pivots_.data());
  }
  // rest_ <- its solution.
  void solve_matrix() {
    const auto n = static_cast<Eigen::Index>(slipping_.size());
    solve_general(DenseMatrix(matrix_.data(), n, n), pivots_.data(), DenseVector(rest_.data(), n));
  }
  enum class Outcome { found, on_another_branch, none, no_number };
  // Newton's method, with this part of the losses. On the branch of motions that begins without losses the determinant
  // is positive; others are those of Painleve's paradox.
  Outcome iterate(double part) {
    const std::size_t n = slipping_.size();
    part_ = part;
    for (int k = 0; k < most_iterations; ++k) {
      update_losses();
      double left = 0;
      double size = 0;
      bool is_finite = true;
      for (std::size_t j = 0; j < n; ++j) {
        double sum = 0;
        each_load(j, &Load::losses, [&](std::size_t l, double factor) { sum += factor * loads_[l].size(); });
        rest_[j] = -(torque_of(j) + slipping_[j].direction * sum);
        is_finite = is_finite && std::isfinite(rest_[j]);
        left = std::max(left, std::abs(rest_[j]));
        size = std::max(size, std::abs(sum));
      }
      if (!is_finite) return Outcome::no_number;
      const bool is_continued = set_matrix();
      if (left <= tolerance * size || (k > 2 && left <= rounding * size))
        return is_continued ? Outcome::found : Outcome::on_another_branch;
      solve_matrix();
      for (std::size_t j = 0; j < n; ++j) {
        torque_of(j) += rest_[j];
        add(j, rest_[j]);
      }
    }
    return Outcome::none;
  }
  // Follows the motion without losses to the whole of them.
  bool follow() {
    for (Load& load : loads_) load.force = load.without_friction;
    std::ranges::fill(torque_, 0.0);
    for (int k = 1; k <= parts; ++k) {
      if (iterate(static_cast<double>(k) / parts) != Outcome::found) return false;
    }
    return true;
  }
  // Not inline: it takes no part where friction is that of bearings and usual gears.
  [[gnu::noinline]] void look_further(Outcome outcome) {
    if (outcome != Outcome::no_number && follow()) return;
    part_ = 1;
    undetermined_ = slipping_.front().force;
    if (outcome == Outcome::no_number) return;  // it does not seize
    // With the load of one mesh there are two linear equations.
    const auto owner = [](const Load& load) { return load.is.force; };
    const auto own = std::ranges::find(loads_, undetermined_, owner);
    if (slipping_.size() == 1 && own->is.of == FrictionLoad::Of::mesh && !own->has_curved_losses &&
        std::ranges::count(loads_, undetermined_, owner) == 1)
      seized_ = undetermined_;
  }
  static void add_to(double* to, const std::vector<double>& what, double factor) {
    for (std::size_t i = 0; i < what.size(); ++i) to[i] += factor * what[i];
  }

  const Model<A>& model_;
  const Loads& of_scene_;
  const Workspace<A>& ws_;
  const double* signals_;
  std::vector<Load> loads_;
  std::vector<int> owners_;  // frictions with loads
  std::vector<Slipping> slipping_;
  std::vector<double> torque_;
  std::vector<double> vdot_, lambda_, unused_;
  std::vector<double> column_, column_rows_, multipliers_of_one_;
  std::vector<std::vector<double>> responses_, multipliers_, holding_;  // by what slips: vdot, lambda, holding forces
  std::vector<std::array<double, 3>> K_;                                // by load and what slips
  std::vector<double> matrix_, rest_;
  std::vector<int> pivots_;
  kernels::JointWrenches<A> wrenches_;
  double force_size_ = 0;
  double part_ = 1;  // of the losses
  bool is_frozen_ = false;
  int undetermined_ = -1, seized_ = -1;
};

}  // namespace gelenk
