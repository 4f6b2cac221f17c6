// SPDX-License-Identifier: BSD-3-Clause
// A value that a scene gives as an expression of named variables, such as "0.4 + 0.35*sin(pi*t)".
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "expression/error.h"
#include "expression/graph.h"
#include "expression/parse.h"
#include "expression/tape.h"

namespace gelenk {

// A variable of a formula, with its unit in FMI's spelling; expressions are in SI units. One without a name keeps its
// place only.
struct FormulaVariable {
  std::string_view name, unit;
  bool everywhere = false;  // it is not of the coordinate to which the element refers
};

// What formulas may name besides the variables of their element.
struct FormulaNames {
  struct Constant {
    std::string name;
    double value = 0;
  };
  struct Expression {
    std::string name, text;
  };
  std::vector<Constant> constants;
  std::vector<std::string> signals;     // inputs of the scene and states of elements
  std::vector<Expression> expressions;  // of these, in place of which names are used
  std::vector<expression::NamedTable> tables;
  // Coordinates of joints and their rates, such as "A.phi", and outputs that depend on accelerations, such as forces;
  // in any order; null: none.
  std::shared_ptr<const std::unordered_set<std::string>> coordinates, forces;
  bool any = false;  // any other name is one of a signal
};
inline constexpr std::string_view time_signal = "t";

// The branches on which formulas are held, those of all formulas one after the other; null: on those of the state.
struct HeldBranches {
  const bool* first = nullptr;
};

// The range of the value of a formula; one that is not constant and beyond counts as that at the bound.
struct FormulaBounds {
  double lower = -HUGE_VAL, upper = HUGE_VAL;
};

// What a formula may name besides variables and constants: the time, signals and coordinates; forces and accelerations.
enum class FormulaReads { nothing, signals, forces };

class Formula {
 public:
  static constexpr std::size_t max_variables = 9;
  static constexpr std::size_t max_signals = 3 * dual_directions - 2;  // in one formula

  Formula() = default;  // not given
  // Throws expression::SyntaxError, also for a text that is too long to be evaluated.
  Formula(std::string text, std::span<const FormulaVariable> variables, const FormulaNames& known = {},
          FormulaReads reads = FormulaReads::nothing, const FormulaBounds& bounds = {});

  // The time derivative of a formula without variables. rate_of: the text of the rate of a signal; none: it has none,
  // and expression::SyntaxError is thrown where the formula depends on it. known: what these texts may name.
  using RateOf = std::function<std::optional<std::string>(std::string_view signal)>;
  friend Formula time_derivative(const Formula& of, const FormulaNames& known, const RateOf& rate_of);
  // Whether forces decide on its k-th branch: it is never held.
  friend bool is_decided_by_forces(const Formula& of, int k) {
    return !of.parsed_->by_forces.empty() && of.parsed_->by_forces[static_cast<std::size_t>(k)];
  }

  // Reads the text again with other constants; keeps the sizes.
  void renew(std::span<const FormulaVariable> variables, const FormulaNames& names);

  bool is_given() const { return parsed_ != nullptr; }
  std::string_view text() const { return is_given() ? std::string_view(parsed_->text) : std::string_view(); }
  const expression::Graph& graph() const { return parsed_->graph; }
  expression::Term term() const { return parsed_->term; }

  // The SI values of one unit of the result and of the k-th variable, in the unit system of the scene.
  double size() const { return size_; }
  double size_of(std::size_t k) const { return sizes_[k]; }
  void set_sizes(double of_result, std::span<const double> of_variables);

  bool reads_time() const { return is_given() && parsed_->reads_clock(); }
  // Whether it names forces or accelerations. Outputs and rates of element states may: nothing else waits until these
  // are known.
  bool reads_forces() const { return is_given() && !parsed_->forces.empty(); }
  // The signals that it names; for each, after bind_signal(): its index among all signals.
  std::span<const std::string> signal_names() const {
    return is_given() ? std::span<const std::string>(parsed_->signals) : std::span<const std::string>();
  }
  std::span<const int> signals() const { return {signals_, signal_names().size()}; }
  // Of the k-th signal that it names. size: SI value of its unit.
  void bind_signal(std::size_t k, int index, double size) {
    signals_[k] = index;
    signal_sizes_[k] = size;
  }
  // branches: must outlive the formula; first_branch: of this formula.
  void bind_branches(const HeldBranches* branches, int first_branch) {
    branches_ = branches;
    first_branch_ = first_branch;
  }
  int branches() const { return is_given() ? parsed_->tape.choices() : 0; }
  const expression::Tape& tape() const { return parsed_->tape; }
  // The time among all signals, and the SI value of its unit, if the formula reads it.
  struct Clock {
    int signal = -1;
    double second = 1;
  };
  Clock clock() const {
    return reads_time() ? Clock{signals_[parsed_->clock], signal_sizes_[parsed_->clock]} : Clock();
  }
  int first_branch() const { return first_branch_; }

  // The value, in the unit system of the scene, as are the variables and the signals that it names. T: double, Dual or
  // Series.
  template <class T>
  [[gnu::noinline]] T value(const T* variables, const T* signals = nullptr) const {
    T at[max_variables + max_signals];
    load(variables, signals, at);
    T out;
    const bool* held = held_branches();
    if (held != nullptr && !parsed_->by_forces.empty()) return held_without_forces(at, held);
    parsed_->tape.evaluate(at, &out, held);
    // Beyond its kink a branch may be undefined, such as that of max(0, -s)^1.5; the step ends at the kink anyway.
    if (held != nullptr && !std::isfinite(value_of(out))) parsed_->tape.evaluate(at, &out);
    return out * T(1 / size_);
  }
  // The same from all signals.
  template <class T>
  T value_among(const T* variables, const T* all) const {
    std::array<T, max_signals> named;
    take_signals(all, named.data());
    return value(variables, named.data());
  }
  // The signals that it names, from all.
  template <class T>
  void take_signals(const T* all, T* named) const {
    for (std::size_t k = 0; k < parsed_->signals.size(); ++k) named[k] = all[signals_[k]];
  }
  // The same with derivatives: along the motion by their rates, of which those that are not known are NaN; with respect
  // to signals of known rate, and to the others. rates: of all but the time; null: none is known.
  struct SignalDirections {
    int along_motion, known, unknown;
  };
  void take_signals(const double* all, const double* rates, const SignalDirections& along, Dual* named) const {
    for (std::size_t k = 0; k < parsed_->signals.size(); ++k) {
      if (signals_[k] < 0) {  // a force
        named[k] = Dual(0);
        continue;
      }
      named[k] = Dual(all[signals_[k]]);
      const double rate = k == parsed_->clock ? 1 : rates == nullptr ? NAN : rates[signals_[k]];
      if (std::isnan(rate)) {
        named[k].derivatives()[along.unknown] = 1;
        continue;
      }
      named[k].derivatives()[along.along_motion] = rate;
      if (k != parsed_->clock) named[k].derivatives()[along.known] = 1;
    }
  }
  // The same, on the branches of the state, with what decides on each of them, if not null: the first one is taken
  // where that is positive. Periodic tables stay in the period that is held.
  template <class T>
  [[gnu::noinline]] T decide(const T* variables, const T* signals, T* arguments) const {
    T at[max_variables + max_signals];
    load(variables, signals, at);
    T out;
    const bool* held = held_branches();
    parsed_->tape.evaluate(at, &out, nullptr, arguments, held);
    return out * T(1 / size_);
  }

 private:
  static constexpr std::size_t most_by_forces = 64;  // branches of an expression in which forces decide on some

  // What a text says, immutable and shared by copies, which allocate nothing.
  struct Parsed {
    std::string text;
    expression::Graph graph;
    expression::Term term = -1;
    expression::Tape tape;             // of the term
    std::size_t count = 0;             // number of variables
    std::vector<std::string> signals;  // that it names
    std::size_t clock = max_signals;   // which of them is the time
    FormulaReads reads = FormulaReads::nothing;
    FormulaBounds bounds{};
    std::vector<std::string> forces;  // that it names
    std::vector<bool> by_forces;      // by branch: whether they decide on it; empty: on none

    bool reads_clock() const { return clock < signals.size(); }
    // Makes the tape of the term. Throws expression::SyntaxError for one that is too long.
    void finish();
  };

  const bool* held_branches() const {
    return branches_ == nullptr || branches_->first == nullptr ? nullptr : branches_->first + first_branch_;
  }
  // The value on the held branches and, where forces decide, on those of the present ones.
  template <class T>
  [[gnu::noinline]] T held_without_forces(const T* at, const bool* held) const {
    std::array<T, most_by_forces> arguments;
    T out;
    parsed_->tape.evaluate(at, &out, nullptr, arguments.data(), held);
    std::array<bool, most_by_forces> branches;
    for (std::size_t k = 0; k < parsed_->by_forces.size(); ++k)
      branches[k] = parsed_->by_forces[k] ? value_of(arguments[k]) > 0 : held[k];
    parsed_->tape.evaluate(at, &out, branches.data());
    return out * T(1 / size_);
  }
  template <class T>
  void load(const T* variables, const T* signals, T* at) const {
    const std::size_t count = parsed_->count;
    for (std::size_t k = 0; k < count; ++k) at[k] = T(sizes_[k]) * variables[k];
    for (std::size_t k = 0; k < parsed_->signals.size(); ++k) at[count + k] = T(signal_sizes_[k]) * signals[k];
  }

  std::shared_ptr<const Parsed> parsed_;
  double size_ = 1;
  double sizes_[max_variables] = {1, 1, 1, 1, 1, 1, 1, 1, 1};
  int signals_[max_signals] = {};
  double signal_sizes_[max_signals] = {};
  const HeldBranches* branches_ = nullptr;
  int first_branch_ = 0;
};

Formula time_derivative(const Formula& of, const FormulaNames& known, const Formula::RateOf& rate_of);
bool is_decided_by_forces(const Formula& of, int k);
// The signals that it names, from all; 0 for forces, which are not among these.
template <class T>
void take_known_signals(const Formula& of, const T* all, T* named) {
  for (const int signal : of.signals()) *named++ = signal < 0 ? T(0) : all[signal];
}
// Whether it names the k-th variable.
inline bool names_variable(const Formula& of, int k) { return of.graph().depends_on(of.term(), k); }
// Whether there are points where a derivative or the value jumps.
inline bool has_kinks(const Formula& of) { return of.graph().has_choices(of.term()); }
// The value in SI units if it is one number.
inline std::optional<double> constant_value(const Formula& of) {
  if (!of.is_given() || !of.graph().is_constant(of.term())) return std::nullopt;
  return of.graph()[of.term()].value;
}

}  // namespace gelenk
