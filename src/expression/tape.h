// SPDX-License-Identifier: BSD-3-Clause
// Terms of a graph as a list of instructions, which evaluates them for double, dual numbers or power series without
// allocation.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "expression/functions.h"
#include "expression/graph.h"

namespace gelenk::expression {

class Tape {
 public:
  static constexpr int max_slots = 512;
  Tape() = default;  // of no terms
  // Throws std::length_error if the terms need more than max_slots intermediate values at once.
  Tape(const Graph& graph, const std::vector<Term>& terms);

  // Instructions of one evaluation; without variables and constants.
  int operations() const { return static_cast<int>(instructions_.size()); }
  int choices() const { return choices_; }

  // out[k] <- the k-th of the terms. variables: by index. held: by choice, whether the first branch is taken; null: as
  // the values say. arguments: by choice, what decides on its branch, if not null.
  template <class T>
  void evaluate(const T* variables, T* out, const bool* held = nullptr, T* arguments = nullptr) const {
    // Zeros in the unused rest of a large array would take longer than a short law.
    if (slots_ <= few_slots) return run<T, few_slots>(variables, out, held, arguments);
    run<T, max_slots>(variables, out, held, arguments);
  }

 private:
  static constexpr int few_slots = 24;

  struct Instruction {
    Operation operation = Operation::constant;
    std::array<short, 3> of{};
    short to = 0;
    int index = 0;  // exponent; of a choice
  };

  template <class T, int size>
  void run(const T* variables, T* out, const bool* held, T* arguments) const {
    std::array<T, size> x;
    for (const auto& [slot, index] : variables_) x[static_cast<std::size_t>(slot)] = variables[index];
    for (const auto& [slot, value] : constants_) x[static_cast<std::size_t>(slot)] = T(value);
    const auto at = [&](const Instruction& i, int k) -> const T& {
      return x[static_cast<std::size_t>(i.of[static_cast<std::size_t>(k)])];
    };
    for (const Instruction& i : instructions_) {
      T& to = x[static_cast<std::size_t>(i.to)];
      switch (i.operation) {
        case Operation::add:
          to = at(i, 0) + at(i, 1);
          break;
        case Operation::subtract:
          to = at(i, 0) - at(i, 1);
          break;
        case Operation::multiply:
          to = at(i, 0) * at(i, 1);
          break;
        case Operation::divide:
          to = at(i, 0) / at(i, 1);
          break;
        case Operation::negate:
          to = -at(i, 0);
          break;
        case Operation::integer_power:
          to = integer_power(at(i, 0), i.index);
          break;
        case Operation::power:
          to = power(at(i, 0), at(i, 1));
          break;
        case Operation::atan2: {
          using std::atan2;
          to = atan2(at(i, 0), at(i, 1));
          break;
        }
        case Operation::choose: {
          if (arguments != nullptr) arguments[i.index] = at(i, 0);
          const bool first = held != nullptr ? held[i.index] : at(i, 0) > T(0);
          to = first ? at(i, 1) : at(i, 2);
          break;
        }
        default:
          to = applied(i.operation, at(i, 0));
      }
    }
    for (std::size_t k = 0; k < outputs_.size(); ++k) out[k] = x[static_cast<std::size_t>(outputs_[k])];
  }

  struct Loaded {
    short slot = 0;
    int index = 0;
  };
  struct Constant {
    short slot = 0;
    double value = 0;
  };
  std::vector<Loaded> variables_;
  std::vector<Constant> constants_;
  std::vector<Instruction> instructions_;
  std::vector<short> outputs_;
  int choices_ = 0;
  int slots_ = 0;
};

}  // namespace gelenk::expression
