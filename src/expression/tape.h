// SPDX-License-Identifier: BSD-3-Clause
// Terms of a graph as a list of instructions, which evaluates them for double, dual numbers or power series without
// allocation.
#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "expression/functions.h"
#include "expression/graph.h"
#include "expression/lookup.h"

namespace gelenk::expression {

class Tape {
 public:
  static constexpr int max_slots = 512;
  Tape() = default;  // of no terms
  // clock: the variable that is the time, in which tables have no choices but breaks; -1: none. Throws
  // std::length_error if the terms need more than max_slots intermediate values at once.
  Tape(const Graph& graph, const std::vector<Term>& terms, int clock = -1);

  // Instructions of one evaluation; without variables and constants.
  int operations() const { return static_cast<int>(instructions_.size()); }
  // What has two branches: each choice, and each knot of a table.
  int choices() const { return choices_; }
  // What the i-th choice depends on, a term of the graph.
  Term deciding(int i) const { return deciding_[static_cast<std::size_t>(i)]; }
  // Whether the i-th choice is a knot of a table.
  bool is_knot(int i) const;
  // The next time after t at which a table of the time has a knot; infinite: none.
  double next_break(double t) const;
  bool has_breaks() const { return !breaks_.empty(); }
  // What is said of a table that has no value at these arguments (see Tape::evaluate) and this time; empty: each has.
  std::string missing_value(const double* arguments, double t) const;
  // Whether at these no derivative jumps but the second.
  bool is_steady() const;

  // out[k] <- the k-th of the terms. variables: by index. held: by choice, whether the first branch is taken; null: as
  // the values say. arguments: by choice, what decides on its branch, if not null. Those of periodic tables are
  // continuous while `periods` is held; null: as `held`.
  template <class T>
  void evaluate(const T* variables, T* out, const bool* held = nullptr, T* arguments = nullptr,
                const bool* periods = nullptr) const;

 private:
  static constexpr int few_slots = 24;

  struct Instruction {
    Operation operation = Operation::constant;
    std::array<short, 3> of{};
    short to = 0;
    int index = 0;  // exponent; of a choice or a lookup
  };
  struct Lookup {
    Graph::Lookup of;
    FirstChoices choices = no_choices;  // of its knots
  };
  // A table whose argument is a*t + b.
  struct Break {
    std::shared_ptr<const Table> table;
    std::size_t axis = 0;
    double a = 0, b = 0;
  };

  void add_lookup(const Graph& graph, const Node& node, int clock);
  template <class T, int size>
  void run(const T* variables, T* out, const bool* held, T* arguments, const bool* periods) const;

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
  std::vector<Lookup> lookups_;
  std::vector<Break> breaks_;
  std::vector<short> outputs_;
  std::vector<Term> deciding_;  // by choice
  int choices_ = 0;
  int slots_ = 0;
};

extern template void Tape::evaluate(const double*, double*, const bool*, double*, const bool*) const;
extern template void Tape::evaluate(const Dual*, Dual*, const bool*, Dual*, const bool*) const;
extern template void Tape::evaluate(const Series*, Series*, const bool*, Series*, const bool*) const;

}  // namespace gelenk::expression
