// SPDX-License-Identifier: BSD-3-Clause
// Implementation of ResidualEvaluator for any number type.
#pragma once

#include "derivatives/residual_evaluator.h"

#include <algorithm>
#include <numeric>

#include "kinematics/coordinate_kernels.h"
#include "kinematics/coordinate_rows.h"
#include "kinematics/friction_loads.h"
#include "kinematics/kernels.h"
#include "kinematics/switching_force.h"
#include "kinematics/with_readings.h"

namespace gelenk {
template <class A>
class ResidualEvaluatorOf final : public WithReadings<A, ResidualEvaluator<typename A::Scalar>> {
  using Base = WithReadings<A, ResidualEvaluator<typename A::Scalar>>;
  using T = typename A::Scalar;
  using Base::cut_reference_;
  using Base::loads_;
  using Base::model_;
  using Base::q_;
  using Base::targets_;
  using Base::v_;
  using Base::ws_;

 public:
  ResidualEvaluatorOf(const Mechanism& mechanism, const Loads& loads)
      : Base(mechanism, loads),
        links_(mechanism.links.size() - 1),
        r_(mechanism.nv),
        c_(mechanism.rows),
        qdot_(mechanism.nq),
        cut_q_(mechanism.cut_nq),
        friction_loads_(friction_loads(model_, loads)) {
    std::iota(links_.begin(), links_.end(), 1);
    if (friction_loads_.empty()) return;
    this->loaded_friction_.resize(switching_forces_of(loads).size());
    turns_.resize(model_.cuts.size());
    for (const FrictionLoad& load : friction_loads_) {
      if (load.cut >= 0) turns_[static_cast<std::size_t>(load.cut)] = turn_of_cut_joint(model_, load.cut, ws_);
    }
  }

  void set_position(const T* q) override {
    std::copy(q, q + model_.nq, q_.begin());
    kernels::positions(model_, q, ws_);
    kernels::root_poses(model_, links_, ws_);
    kernels::loop_positions(model_, ws_);
    kernels::coordinate_row_positions(model_, q, targets_, ws_);
  }

  void hold(const int* sides) override { sides_ = sides; }
  void apply_forces(const typename Readings<T>::Force* wrenches) override { wrenches_ = wrenches; }

  void set_targets(const T* targets) override { std::copy_n(targets, targets_.size(), targets_.begin()); }

  void set_velocity(const T* v) override {
    std::copy(v, v + model_.nv, v_.begin());
    kernels::velocities(model_, q_.data(), v, kernels::root_acceleration<A>(loads_), ws_);
    kernels::loop_velocities(model_, ws_);
    kernels::coordinate_row_velocities(model_, q_.data(), v, targets_, ws_);
    kernels::coordinate_rates(model_, q_.data(), v, qdot_.data());
  }

  void set_acceleration(const T* given, const T* vdot, const T* lambda) override {
    const T* const u = this->with_named(given);
    kernels::link_loads(model_, loads_, u, ws_);
    const int* of_cuts = sides_ == nullptr ? nullptr : sides_ + loads_.tree.switching_count();
    kernels::cut_loads(model_, loads_, u, cut_reference_.data(), ws_, of_cuts);
    if constexpr (!A::planar) {
      for (std::size_t i = 1; i < model_.links.size() && wrenches_ != nullptr; ++i)
        ws_.F_ext[i] += ws_.X_0L[i].to_child(wrenches_[i]);
    }
    std::copy(lambda, lambda + model_.rows, ws_.lambda.begin());
    kernels::accelerations(model_, vdot, ws_);
    kernels::loop_accelerations(model_, ws_, c_.data());
    kernels::coordinate_row_accelerations(model_, vdot, targets_, ws_, c_.data());
    // accelerations() sets ws_.F to the wrench that each joint transmits; along S it consists of motors, springs and
    // the forces of coordinate constraints.
    std::ranges::fill(r_, T(0));
    loads_.tree.add(q_.data(), v_.data(), u, r_.data(), sides_);
    for (std::size_t i = 1; i < model_.links.size(); ++i) {
      const auto& link = model_.links[i];
      for (int k = link.iv; k < link.iv + link.nv; ++k) {
        r_[k] = A::dot(ws_.S[k], ws_.F[i]) - r_[k] + loads_.added_inertia[k] * vdot[k];
      }
    }
    kernels::each_coordinate_row(model_, [&](const CoordinateRow& row, std::size_t i, std::size_t k) {
      const T& l = lambda[model_.first_coordinate_row + i];
      for (const CoordinateRow::Term& term : row.terms) r_[term.v] += kernels::factor_of(row, term, k++, ws_) * l;
    });
    if (!friction_loads_.empty()) add_loaded_friction(u, lambda);
  }

  const T* all_signals(const T* u) override { return this->with_named(u); }
  void set_cut_reference(const double* q) override { std::copy(q, q + model_.cut_nq, cut_reference_.begin()); }

  const std::vector<T>& Phi() const override { return ws_.Phi; }
  const std::vector<T>& row_rates() const override { return ws_.rate; }
  const std::vector<T>& qdot() const override { return qdot_; }
  const std::vector<T>& force_residual() const override { return r_; }
  const std::vector<T>& acceleration_residual() const override { return c_; }
  const std::vector<T>& cut_coordinates() override {
    for (int c = 0; c < static_cast<int>(model_.cuts.size()); ++c) {
      this->counted_coordinates(c, cut_q_.data() + model_.cuts[c].iq);
    }
    return cut_q_;
  }

 private:
  // The friction in motion that depends on the forces of bearings and meshes, after accelerations().
  void add_loaded_friction(const T* u, const T* lambda) {
    std::ranges::fill(this->loaded_friction_, T(0));
    int index = 0;
    const auto add = [&](const auto& force, const T* q, const T* v) {
      if constexpr (TakesLoads<std::decay_t<decltype(force.element)>>) {
        const int side = sides_ == nullptr ? force.side(q, v) : sides_[index];
        for (const FrictionLoad& load : friction_loads_) {
          if (load.force != index || (side != 1 && side != -1)) continue;
          const std::array<T, 3> transmitted = transmitted_force(load, this->model_, this->ws_, this->ws_.F, lambda);
          const T speed = T(force.sign) * v[force.v];
          const T of_bearing =
              force.with_inputs(u, [&](const T* own) { return force.element.load_factor(side, speed, own); });
          std::array<T, 2> of_mesh{T(0), T(0)};
          if (load.of == FrictionLoad::Of::mesh)
            of_mesh = this->loads_.losses[static_cast<std::size_t>(load.row)].at(speed, size_of_load(transmitted), u);
          const T factor = load.friction_per_size(side, transmitted[0] < T(0) ? -1 : 1, of_mesh, of_bearing);
          const T friction = T(-side) * factor * size_of_load(transmitted);
          this->loaded_friction_[static_cast<std::size_t>(index)] += friction;
          add_along(load, T(T(-force.sign) * friction));
        }
      }
      ++index;
    };
    kernels::each_switching(model_, loads_, ws_, q_.data(), v_.data(), cut_reference_.data(), add);
  }
  // Adds to the residual a force along the coordinate of a friction, in the mechanism's sign.
  void add_along(const FrictionLoad& load, const T& force) {
    if (load.cut < 0) {
      r_[load.velocity] += force;
    } else {
      for (const auto& [k, factor] : turns_[static_cast<std::size_t>(load.cut)]) r_[k] += factor * force;
    }
  }

  std::vector<int> links_;
  const int* sides_ = nullptr;
  const typename Readings<T>::Force* wrenches_ = nullptr;
  std::vector<T> r_, c_, qdot_, cut_q_;
  std::vector<FrictionLoad> friction_loads_;
  std::vector<std::vector<std::pair<int, T>>> turns_;  // by cut with such friction: the rate of its angle
};

template <class T>
std::unique_ptr<ResidualEvaluator<T>> make_residual_evaluator(const Mechanism& mechanism, const Loads& loads) {
  if (mechanism.planar) return std::make_unique<ResidualEvaluatorOf<PlanarAlgebra<T>>>(mechanism, loads);
  return std::make_unique<ResidualEvaluatorOf<SpatialAlgebra<T>>>(mechanism, loads);
}

}  // namespace gelenk
