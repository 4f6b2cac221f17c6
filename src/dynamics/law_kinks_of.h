// SPDX-License-Identifier: BSD-3-Clause
// Implementation of LawKinks.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "derivatives/signal_derivatives.h"
#include "dynamics/joint_laws.h"
#include "dynamics/law_kinks.h"
#include "dynamics/named_rates.h"
#include "kinematics/placed_formulas.h"
#include "math/dual.h"

namespace gelenk {

template <class A>
class LawKinksOf final : public LawKinks {
 public:
  // kinematics: of the same state. with_named: see WithReadings.
  LawKinksOf(const typename JointLaws<A>::State& state, const JointLaws<A>& laws, const Mechanism& mechanism,
             const Kinematics& kinematics, std::function<const double*(const double*)> with_named)
      : state_(state), laws_(laws), kinematics_(kinematics), with_named_(std::move(with_named)) {
    const auto look = [&](const Formula& formula) {
      count_ = std::max(count_, formula.first_branch() + formula.branches());
      reads_time_ = reads_time_ || (formula.branches() > 0 && formula.reads_time());
      for (int k = 0; k < formula.branches() && !may_jump_; ++k) may_jump_ = !formula.tape().is_knot(k);
    };
    laws_.each_branching([&](const auto& force, int, const double*, const double*) {
      look(force.element.formula());
      depends_on_speed_ = depends_on_speed_ || force.element.reads_speed();
    });
    each_formula(std::as_const(*state_.loads.forces), [&](const Formula& formula, int) {
      look(formula);
      between_bodies_ = between_bodies_ || formula.branches() > 0;
    });
    each_of_states(look);
    laws_.each_branching_loss([&](const Formula& formula, int) {
      look(formula);
      depends_on_speed_ = depends_on_speed_ || names_variable(formula, 0);
    });
    if (count_ > 0 && state_.loads.signals() > state_.loads.first_state) {
      signals_.resize(static_cast<std::size_t>(state_.loads.signals()));
      rates_.resize(signals_.size(), NAN);
      const auto moves = [](const NamedQuantity& of) { return of.is_rate || of.reading != nullptr; };
      depends_on_speed_ = depends_on_speed_ || std::ranges::any_of(state_.loads.named, moves);
      if (names_beyond_tree(state_.loads)) named_rates_.emplace(mechanism, state_.loads);
    }
    courses_.resize(static_cast<std::size_t>(count_));
    values_.resize(courses_.size());
    arguments_.resize(courses_.size());
  }

  int count() const override { return count_; }
  bool need_accelerations() const override { return depends_on_speed_; }
  bool read_time() const override { return reads_time_; }

  void indicators(const double* vdot, double* g, double* gdot) override {
    using At = kernels::BranchDirections;
    const double* const all = signals();
    find_rates(all, vdot);
    const double* const rates = rates_.empty() ? nullptr : rates_.data();
    if (between_bodies_) kernels::force_branches(state_.loads, all, rates, state_.ws, arguments_.data());
    each_of_states([&](const Formula& formula) {
      std::array<Dual, Formula::max_signals> signals;
      formula.take_signals(all, rates, At::of_signals, signals.data());
      formula.decide<Dual>(nullptr, signals.data(), arguments_.data() + formula.first_branch());
      leave_to_forces(formula, arguments_.data());
    });
    laws_.each_branching([&](const auto& force, int cut, const double* q, const double* v) {
      Dual at(force.sign * q[force.q]);
      Dual speed(force.sign * v[force.v]);
      at.derivatives()[At::along_motion] = speed.value();
      if (vdot != nullptr) speed.derivatives()[At::along_motion] = laws_.acceleration_along(force, cut, vdot);
      at.derivatives()[At::position] = 1;
      speed.derivatives()[vdot == nullptr ? At::velocity : At::position + 1] = 1;  // whether its rate is unknown
      std::array<Dual, Formula::max_signals> signals;
      const Formula& formula = force.element.formula();
      formula.take_signals(all, rates, At::of_signals, signals.data());
      force.element.decide(at, speed, signals.data(), arguments_.data() + formula.first_branch());
    });
    laws_.each_branching_loss([&](const Formula& formula, int v) {
      std::array<Dual, 2> motion{Dual(std::abs(state_.v[static_cast<std::size_t>(v)])), Dual(0)};
      Dual& speed = motion[0];
      const double sign = state_.v[static_cast<std::size_t>(v)] < 0 ? -1 : 1;
      if (vdot != nullptr) speed.derivatives()[At::along_motion] = sign * vdot[v];
      speed.derivatives()[vdot == nullptr ? At::velocity : At::position + 1] = 1;  // whether its rate is unknown
      std::array<Dual, Formula::max_signals> signals;
      formula.take_signals(all, rates, At::of_signals, signals.data());
      formula.decide(motion.data(), signals.data(), arguments_.data() + formula.first_branch());
    });
    for (int i = 0; i < count_; ++i) {
      const Dual& of = arguments_[static_cast<std::size_t>(i)];
      Course& at = courses_[static_cast<std::size_t>(i)];
      if (held_branches() == nullptr) at.begin(of.derivatives());
      gdot[i] = rate_of(of) / at.size;
      g[i] = settled(i, of.value() / at.size, gdot[i]);
      if (held_branches() == nullptr) at.begins_on_kink = std::abs(of.value()) <= state_rounding * at.size;
    }
  }

  std::span<const bool> held() const override {
    return {held_branches(), held_branches() == nullptr ? 0 : static_cast<std::size_t>(count_)};
  }
  void hold(const bool* positive) override { state_.loads.branches->first = positive; }

  bool are_passed() override {
    // Beyond a point of a table its polynomial is as good until the step ends there.
    if (held_branches() == nullptr || !may_jump_) return false;
    decide();
    for (int i = 0; i < count_; ++i) {
      if (distance(i) < -state_rounding) return true;
    }
    return false;
  }

  void resets(double* when, double* to) override {
    const double* const all = signals();
    for (const PlacedReset& reset : state_.loads.resets) {
      *when++ = reset.when.value_among<double>(nullptr, all);
      *to++ = reset.to.value_among<double>(nullptr, all);
    }
  }

  std::string missing_value() override {
    if (count_ > 0) decide();
    const double* const all = signals();
    std::string out;
    each_placed_formula(state_.loads, [&](const Formula& formula, const BranchPlace& place) {
      if (!holds_branches(formula, place)) return;
      const Formula::Clock clock = formula.clock();
      const double t = clock.signal < 0 ? 0 : all[clock.signal] * clock.second;
      if (out.empty()) out = formula.tape().missing_value(values_.data() + formula.first_branch(), t);
    });
    return out;
  }

  void distances(double* out) override {
    decide();
    for (int i = 0; i < count_; ++i) out[i] = distance(i);
  }

 private:
  // The rates of element states, the conditions of their resets, and the accelerations of motions that follow them.
  template <class Visit>
  void each_of_states(Visit visit) const {
    for (const Formula& rate : state_.loads.rates) visit(rate);
    for (const PlacedReset& reset : state_.loads.resets) visit(reset.when);
    for (const auto& motion : state_.loads.motions) {
      if (motion[2].is_given()) visit(motion[2]);
    }
  }

  // Forces are not known here: the branches on which they decide never change.
  template <class T>
  static void leave_to_forces(const Formula& formula, T* arguments) {
    for (int k = 0; k < formula.branches(); ++k) {
      if (is_decided_by_forces(formula, k)) arguments[formula.first_branch() + k] = T(1);
    }
  }

  // What decides on each branch at the present state.
  void decide() {
    const double* const all = signals();
    if (between_bodies_) kernels::force_branches(state_.loads, all, nullptr, state_.ws, values_.data());
    each_of_states([&](const Formula& formula) {
      std::array<double, Formula::max_signals> signals;
      take_known_signals(formula, all, signals.data());
      formula.decide<double>(nullptr, signals.data(), values_.data() + formula.first_branch());
      leave_to_forces(formula, values_.data());
    });
    laws_.each_branching([&](const auto& force, int, const double* q, const double* v) {
      std::array<double, Formula::max_signals> signals;
      const Formula& formula = force.element.formula();
      formula.take_signals(all, signals.data());
      double* const out = values_.data() + formula.first_branch();
      force.element.decide(force.sign * q[force.q], force.sign * v[force.v], signals.data(), out);
    });
    laws_.each_branching_loss([&](const Formula& formula, int v) {
      const double motion[] = {std::abs(state_.v[static_cast<std::size_t>(v)]), 0};
      std::array<double, Formula::max_signals> signals;
      formula.take_signals(all, signals.data());
      formula.decide(motion, signals.data(), values_.data() + formula.first_branch());
    });
  }

  double distance(int i) const {
    const double value = values_[static_cast<std::size_t>(i)] / courses_[static_cast<std::size_t>(i)].size;
    return held_branches()[i] ? value : -value;
  }

  // All signals; what is named of the motion is that of the present state.
  const double* signals() {
    if (signals_.empty()) return laws_.all_inputs();
    const std::span<const double> kept = laws_.inputs();
    std::copy_n(kept.begin(), std::min(kept.size(), signals_.size()), signals_.begin());
    return with_named_(signals_.data());
  }

  // The rates of the signals that have one, after signals(). vdot: the accelerations, or null.
  void find_rates(const double* all, const double* vdot) {
    if (rates_.empty()) return;
    double* out = rates_.data() + state_.loads.first_state;
    for (const Formula& rate : state_.loads.rates)
      *out++ = rate.reads_forces() ? NAN : rate.value_among<double>(nullptr, all);
    if (named_rates_) {
      named_rates_->find(kinematics_, state_.q, state_.v, vdot, state_.cut_reference.data(), out);
      return;
    }
    for (const NamedQuantity& of : state_.loads.named) {
      const double* const rates = of.is_rate ? vdot : state_.v.data();
      *out++ = !of.moves ? 0 : rates == nullptr ? NAN : of.sign * rates[of.v];
    }
  }

  // Part of the natural units of a coordinate and its speed that is rounding of the state.
  static constexpr double state_rounding = 1e-13;

  // Rates above this, in the same unit per second, are no rounding.
  static constexpr double least_rate = 1e-9;

  // What decides on a branch in the course of a step.
  struct Course {
    double size = 1;              // its change by one natural unit of coordinates and speeds, a second and inputs of 1
    bool begins_on_kink = false;  // the step begins there, within rounding

    void begin(const Dual::Directions& derivatives) {
      const double sum = derivatives.abs().sum();
      size = sum > 0 && std::isfinite(sum) ? sum : 1;
    }
  };

  // Within rounding of zero, as of the speed of what has come to rest, the value has no sign: a law that is held stays
  // on its branch, and one that is not is on that of zero. What moves passes the kink.
  double settled(int i, double g, double gdot) const {
    constexpr double least = std::numeric_limits<double>::min();
    if (std::abs(g) > state_rounding || std::abs(gdot) > least_rate) return g;
    if (held_branches() == nullptr) return std::isnan(gdot) && g != 0 ? g : -least;
    if (!courses_[static_cast<std::size_t>(i)].begins_on_kink) return g;
    return held_branches()[i] ? std::max(g, least) : std::min(g, -least);
  }

  const bool* held_branches() const { return state_.loads.branches->first; }

  // The rate of what decides on a branch; NaN if it depends on accelerations that are not known, or on inputs.
  static double rate_of(const Dual& of) {
    using At = kernels::BranchDirections;
    const Dual::Directions& d = of.derivatives();
    const bool is_unknown = d[At::inputs] != 0 || (d.segment<3>(At::velocity) != 0).any();
    return is_unknown ? NAN : d[At::along_motion];
  }

  typename JointLaws<A>::State state_;
  const JointLaws<A>& laws_;
  const Kinematics& kinematics_;
  std::function<const double*(const double*)> with_named_;
  std::optional<NamedRates> named_rates_;  // of what is beyond the tree
  int count_ = 0;
  bool between_bodies_ = false;  // some are of forces between bodies
  bool depends_on_speed_ = false, reads_time_ = false;
  bool may_jump_ = false;        // some are not of tables
  std::vector<Course> courses_;  // by indicator
  std::vector<double> values_;   // by indicator: workspace
  std::vector<Dual> arguments_;  // by indicator: workspace
  // If there are element states, or coordinates that expressions name: all signals, and their rates or NaN.
  std::vector<double> signals_, rates_;
};

}  // namespace gelenk
