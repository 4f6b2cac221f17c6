// SPDX-License-Identifier: BSD-3-Clause
// Implementation of LawKinks.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "dynamics/joint_laws.h"
#include "dynamics/law_kinks.h"
#include "math/dual.h"

namespace gelenk {

template <class A>
class LawKinksOf final : public LawKinks {
 public:
  LawKinksOf(const typename JointLaws<A>::State& state, const JointLaws<A>& laws) : state_(state), laws_(laws) {
    const auto look = [&](const Formula& formula) {
      count_ = std::max(count_, formula.first_branch() + formula.branches());
    };
    laws_.each_branching([&](const auto& force, int, const double*, const double*) {
      look(force.element.formula());
      depends_on_speed_ = depends_on_speed_ || force.element.reads_speed();
    });
    each_formula(std::as_const(*state_.loads.forces), [&](const Formula& formula, int) {
      look(formula);
      between_bodies_ = between_bodies_ || formula.branches() > 0;
    });
    rounding_.resize(static_cast<std::size_t>(count_));
    values_.resize(rounding_.size());
    arguments_.resize(rounding_.size());
  }

  int count() const override { return count_; }
  bool need_accelerations() const override { return depends_on_speed_; }

  void indicators(const double* vdot, double* g, double* gdot) override {
    using At = kernels::BranchDirections;
    if (between_bodies_) kernels::force_branches(state_.loads, laws_.all_inputs(), state_.ws, arguments_.data());
    laws_.each_branching([&](const auto& force, int cut, const double* q, const double* v) {
      Dual at(force.sign * q[force.q]);
      Dual speed(force.sign * v[force.v]);
      at.derivatives()[At::along_motion] = speed.value();
      if (vdot != nullptr) speed.derivatives()[At::along_motion] = laws_.acceleration_along(force, cut, vdot);
      at.derivatives()[At::position] = 1;
      speed.derivatives()[vdot == nullptr ? At::velocity : At::position + 1] = 1;  // whether its rate is unknown
      std::array<Dual, Formula::max_signals> signals;
      const Formula& formula = force.element.formula();
      formula.take_signals(laws_.all_inputs(), At::along_motion, At::inputs, signals.data());
      force.element.decide(at, speed, signals.data(), arguments_.data() + formula.first_branch());
    });
    for (int i = 0; i < count_; ++i) {
      const Dual& of = arguments_[static_cast<std::size_t>(i)];
      const Dual::Directions& d = of.derivatives();
      const double size = d.segment<At::inputs - At::position>(At::position).abs().sum();
      rounding_[static_cast<std::size_t>(i)] = state_rounding * size;
      gdot[i] = rate_of(of);
      g[i] = settled(i, of.value(), gdot[i]);
    }
  }

  std::span<const bool> held() const { return {held_, held_ == nullptr ? 0 : static_cast<std::size_t>(count_)}; }
  void hold(const bool* positive) override { state_.loads.branches->first = held_ = positive; }

  bool are_passed() override {
    if (held_ == nullptr || count_ == 0) return false;
    if (between_bodies_) kernels::force_branches(state_.loads, laws_.all_inputs(), state_.ws, values_.data());
    laws_.each_branching([&](const auto& force, int, const double* q, const double* v) {
      std::array<double, Formula::max_signals> signals;
      const Formula& formula = force.element.formula();
      formula.take_signals(laws_.all_inputs(), signals.data());
      double* const out = values_.data() + formula.first_branch();
      force.element.decide(force.sign * q[force.q], force.sign * v[force.v], signals.data(), out);
    });
    for (int i = 0; i < count_; ++i) {
      const double value = values_[static_cast<std::size_t>(i)];
      if ((value > 0) != held_[i] && std::abs(value) > rounding_[static_cast<std::size_t>(i)]) return true;
    }
    return false;
  }

 private:
  // Part of the natural units of a coordinate and its speed that is rounding of the state.
  static constexpr double state_rounding = 1e-13;

  // Within rounding of zero, as of the speed of what has come to rest, a law that is held stays on its branch; at the
  // start of a step the rate decides.
  double settled(int i, double g, double gdot) const {
    if (std::abs(g) > rounding_[static_cast<std::size_t>(i)]) return g;
    if (held_ == nullptr) return std::isnan(gdot) ? g : 0;
    const double least = std::numeric_limits<double>::min();
    return held_[i] ? std::max(g, least) : std::min(g, -least);
  }

  // The rate of what decides on a branch; NaN if it depends on accelerations that are not known, or on inputs.
  static double rate_of(const Dual& of) {
    using At = kernels::BranchDirections;
    const Dual::Directions& d = of.derivatives();
    const bool is_unknown = d[At::inputs] != 0 || (d.segment<3>(At::velocity) != 0).any();
    return is_unknown ? NAN : d[At::along_motion];
  }

  typename JointLaws<A>::State state_;
  const JointLaws<A>& laws_;
  int count_ = 0;
  bool between_bodies_ = false;  // some are of forces between bodies
  bool depends_on_speed_ = false;
  const bool* held_ = nullptr;
  std::vector<double> rounding_;  // by indicator, at the last indicators()
  std::vector<double> values_;    // by indicator: workspace
  std::vector<Dual> arguments_;   // by indicator: workspace
};

}  // namespace gelenk
