// SPDX-License-Identifier: BSD-3-Clause
// A relation f = 0 between coordinates of joints, or between their rates, in which it is linear; and its derivatives.
// It is divided by the length of its gradient, so that the scale of f does not matter. T: double,
// Dual or Series.
#pragma once

#include <vector>

#include "expression/tape.h"
#include "field/formula.h"

namespace gelenk {

class RelationLaw {
 public:
  // What the relation names, in the order of Formula::signal_names().
  struct Named {
    int term = 0;  // to which of the coordinates it belongs
    bool is_rate = false;
    double size = 1;  // SI value of its unit
  };
  static constexpr int most_terms = static_cast<int>(Formula::max_signals) + 1;

  RelationLaw() = default;  // not to be evaluated
  // gives: of the form x = f, where x is the last one in `named`, which is then beyond the names of f; otherwise f = 0.
  // Throws std::length_error if the derivatives have too many terms.
  RelationLaw(const Formula& f, std::vector<Named> named, int terms, bool gives);

  bool is_of_rates() const { return is_of_rates_; }
  // Whether a relation of rates is linear in them.
  bool is_linear() const { return is_linear_; }

  // The value and its factors of the rates of all coordinates. x, rates: of these.
  template <class T>
  T value(const T* x, const T* rates, T* factors) const;
  // The part of the last derivative of the value that does not depend on accelerations.
  template <class T>
  T bias(const T* x, const T* rates) const;
  // Whether these are finite, and the gradient is not 0.
  bool is_regular(const double* x, const double* rates) const;

 private:
  using Term = expression::Term;
  std::vector<Term> factors_of(expression::Graph& graph, Term value) const;
  template <class T>
  void load(const T* x, const T* rates, T* at) const;
  template <class T>
  T length(const T* factors) const;

  std::vector<Named> named_;
  int terms_ = 0;
  bool is_of_rates_ = false, is_linear_ = true;
  expression::Tape first_;   // f and its factors
  expression::Tape second_;  // the factors, and the change of each along the motion; of rates: and that of f
};

}  // namespace gelenk
