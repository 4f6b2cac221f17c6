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
  void evaluate(const T* variables, T* out, const bool* held = nullptr, T* arguments = nullptr) const;

 private:
  static constexpr int few_slots = 24;

  struct Instruction {
    Operation operation = Operation::constant;
    std::array<short, 3> of{};
    short to = 0;
    int index = 0;  // exponent; of a choice
  };

  template <class T, int size>
  void run(const T* variables, T* out, const bool* held, T* arguments) const;

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

extern template void Tape::evaluate(const double*, double*, const bool*, double*) const;
extern template void Tape::evaluate(const Dual*, Dual*, const bool*, Dual*) const;
extern template void Tape::evaluate(const Series*, Series*, const bool*, Series*) const;

}  // namespace gelenk::expression
