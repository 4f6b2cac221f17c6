// SPDX-License-Identifier: BSD-3-Clause
// A number that records: what is computed with it becomes a graph of expressions (expression/graph.h). Code written for
// any number type thus hands out its equations. The operations are those of dual numbers (math/dual.h).
//
// It has no value, unless it is constant, so that code cannot branch on it: such a branch would be built into the
// expressions without a trace. It throws HiddenBranch instead, and has to be written as choose() (math/choose.h). One
// comparison has an answer: lengths, which are square roots, are greater than 0.
#pragma once

#include <Eigen/Core>
#include <compare>
#include <stdexcept>
#include <utility>
#include <vector>

#include "expression/graph.h"

namespace gelenk::recording {

// A branch on a number without a value.
class HiddenBranch : public std::runtime_error {
 public:
  HiddenBranch() : std::runtime_error("a law with branches that are not written as expressions") {}
};

class Recorded {
 public:
  Recorded() = default;
  Recorded(double value);  // NOLINT(google-explicit-constructor): constants are numbers too
  // Not a constructor: terms are integers, and so are numbers such as T(0).
  static Recorded of(expression::Term term);
  static Recorded variable(int index);

  bool is_constant() const { return term_ < 0; }
  bool is(double value) const { return is_constant() && value_ == value; }
  expression::Term term() const;

  Recorded& operator+=(const Recorded& b) { return *this = *this + b; }
  Recorded& operator-=(const Recorded& b) { return *this = *this - b; }
  Recorded& operator*=(const Recorded& b) { return *this = *this * b; }
  Recorded& operator/=(const Recorded& b) { return *this = *this / b; }

  // Out of line: the kernels are flattened into long functions.
  friend Recorded operator+(const Recorded& a, const Recorded& b);
  friend Recorded operator-(const Recorded& a, const Recorded& b);
  friend Recorded operator-(const Recorded& a);
  friend Recorded operator*(const Recorded& a, const Recorded& b);
  friend Recorded operator/(const Recorded& a, const Recorded& b);

  friend bool operator==(const Recorded& a, const Recorded& b) { return (a <=> b) == 0; }
  friend std::partial_ordering operator<=>(const Recorded& a, const Recorded& b);
  friend double value_of(const Recorded& a);

  friend Recorded sin(const Recorded& a);
  friend Recorded cos(const Recorded& a);
  friend Recorded exp(const Recorded& a);
  friend Recorded sqrt(const Recorded& a);
  friend Recorded abs(const Recorded& a);
  friend Recorded abs2(const Recorded& a) { return a * a; }
  friend Recorded atan2(const Recorded& y, const Recorded& x);

  // g > 0 ? a : b
  static Recorded chosen(const Recorded& g, const Recorded& a, const Recorded& b);
  static Recorded function(expression::Operation operation, const Recorded& a);
  static Recorded power(const Recorded& a, const Recorded& b);

 private:
  friend Recorded in_turn_of(double reference, const Recorded& q);

  // A constant that was computed from others: it is no number of a NumberList.
  static Recorded computed(double value);
  // The operand times a factor: c*x is {c, x}, -x is {-1, x}.
  std::pair<double, Recorded> scaled() const;
  // c + x is {c, x}.
  std::pair<double, Recorded> shifted() const;
  const expression::Node& node() const;

  double value_ = 0;
  expression::Term term_ = -1;  // -1: a constant
};

template <class First, class Second>
Recorded choose(const Recorded& g, const First& first, const Second& second) {
  return Recorded::chosen(g, first(), second());
}
// The angle within half a turn of the reference: numbers of turns are not recorded.
Recorded in_turn_of(double reference, const Recorded& q);
// Axis times angle, of less than half a turn.
Eigen::Matrix<Recorded, 3, 1> rotation_vector(const Eigen::Matrix<Recorded, 3, 3>& R);

// While it exists, it lists the numbers that this thread makes constants of a recording, in the order in which the code
// gives them, which does not depend on their values. So the same code run with other numbers says what the constants of
// the recording would be. Those that are chosen become variables.
class NumberList {
 public:
  // variables: by place in the list, the variable that takes the place of the number; -1: none. Empty: none at all.
  explicit NumberList(std::vector<int> variables = {});
  ~NumberList();
  NumberList(const NumberList&) = delete;
  NumberList& operator=(const NumberList&) = delete;

  const std::vector<double>& numbers() const { return numbers_; }
  // Enters a number; returns its variable, or -1.
  int add(double value);

 private:
  std::vector<int> variables_;
  std::vector<double> numbers_;
  NumberList* outer_;
};

// While it exists, numbers of this thread are recorded in the graph.
class Recording {
 public:
  explicit Recording(expression::Graph& graph);
  ~Recording();
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

 private:
  expression::Graph* outer_;
};

}  // namespace gelenk::recording

template <>
struct Eigen::NumTraits<gelenk::recording::Recorded> : Eigen::NumTraits<double> {
  using Real = gelenk::recording::Recorded;
  using NonInteger = gelenk::recording::Recorded;
  using Nested = gelenk::recording::Recorded;
  using Literal = double;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 1,
    AddCost = 8,
    MulCost = 8
  };
};
