// SPDX-License-Identifier: BSD-3-Clause
// A value that a scene gives as an expression of named variables, such as "0.4 + 0.35*sin(pi*t)".
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "expression/error.h"
#include "expression/graph.h"
#include "expression/tape.h"

namespace gelenk {

// A variable of a formula, with its unit in FMI's spelling; expressions are in SI units. One without a name keeps its
// place only.
struct FormulaVariable {
  std::string_view name, unit;
};

class Formula {
 public:
  static constexpr std::size_t max_variables = 4;

  Formula() = default;  // not given
  // Throws expression::SyntaxError, also for a text that is too long to be evaluated.
  Formula(std::string text, std::span<const FormulaVariable> variables);

  bool is_given() const { return graph_ != nullptr; }
  const std::string& text() const { return text_; }
  // Whether there are points where a derivative or the value jumps.
  bool has_kinks() const { return graph_->has_choices(term_); }
  const expression::Graph& graph() const { return *graph_; }
  expression::Term term() const { return term_; }

  // The SI values of one unit of the result and of the k-th variable, in the unit system of the scene.
  double size() const { return size_; }
  double size_of(std::size_t k) const { return sizes_[k]; }
  void set_sizes(double of_result, std::span<const double> of_variables);

  // The value, in the unit system of the scene, as are the variables. T: double, Dual or Series.
  template <class T>
  T value(const T* variables) const {
    T at[max_variables];
    for (std::size_t k = 0; k < count_; ++k) at[k] = T(sizes_[k]) * variables[k];
    T out;
    tape_->evaluate(at, &out);
    return out * T(1 / size_);
  }

 private:
  std::string text_;
  std::shared_ptr<const expression::Graph> graph_;  // shared by copies; immutable
  expression::Term term_ = -1;
  std::shared_ptr<const expression::Tape> tape_;  // of the term
  std::size_t count_ = 0;                         // number of variables
  double size_ = 1;
  double sizes_[max_variables] = {1, 1, 1, 1};
};

}  // namespace gelenk
