// SPDX-License-Identifier: BSD-3-Clause
#include "recording/recorded.h"

#include <cmath>
#include <numbers>

#include "expression/functions.h"

namespace gelenk::recording {
namespace {

using expression::Graph;
using expression::Node;
using expression::Operation;
using expression::Term;

thread_local Graph* recorded_in = nullptr;
thread_local NumberList* listed_in = nullptr;

}  // namespace

Recording::Recording(Graph& graph) : outer_(recorded_in) { recorded_in = &graph; }
Recording::~Recording() { recorded_in = outer_; }

NumberList::NumberList(std::vector<int> variables) : variables_(std::move(variables)), outer_(listed_in) {
  listed_in = this;
}
NumberList::~NumberList() { listed_in = outer_; }

int NumberList::add(double value) {
  const std::size_t place = numbers_.size();
  numbers_.push_back(value);
  return place < variables_.size() ? variables_[place] : -1;
}

Recorded::Recorded(double value) : value_(value) {
  const int variable = listed_in == nullptr ? -1 : listed_in->add(value);
  if (variable >= 0) *this = Recorded::variable(variable);
}

Recorded Recorded::computed(double value) {
  Recorded out;
  out.value_ = value;
  return out;
}

Recorded Recorded::of(Term term) {
  const Node& node = (*recorded_in)[term];
  if (node.operation == Operation::constant) return computed(node.value);
  Recorded out;
  out.term_ = term;
  return out;
}

Recorded Recorded::variable(int index) { return Recorded::of(recorded_in->variable(index)); }

// There is one zero: 0 and -0 are the same constant.
Term Recorded::term() const { return is_constant() ? recorded_in->constant(value_ == 0 ? 0 : value_) : term_; }

const Node& Recorded::node() const { return (*recorded_in)[term_]; }

std::pair<double, Recorded> Recorded::scaled() const {
  if (is_constant()) return {1, *this};
  const Node& at = node();
  if (at.operation == Operation::negate) return {-1, of(at.of[0])};
  if (at.operation == Operation::multiply) {
    for (const int k : {0, 1}) {
      const Term factor = at.of[static_cast<std::size_t>(k)];
      if (recorded_in->is_constant(factor))
        return {(*recorded_in)[factor].value, of(at.of[static_cast<std::size_t>(1 - k)])};
    }
  }
  return {1, *this};
}

std::pair<double, Recorded> Recorded::shifted() const {
  if (is_constant() || node().operation != Operation::add) return {0, *this};
  const Node& at = node();
  for (const int k : {0, 1}) {
    const Term summand = at.of[static_cast<std::size_t>(k)];
    if (recorded_in->is_constant(summand))
      return {(*recorded_in)[summand].value, of(at.of[static_cast<std::size_t>(1 - k)])};
  }
  return {0, *this};
}

// Constants are gathered, multiples of the same are added up, and negative multiples are subtracted, so that equal
// expressions become one node more often.
Recorded operator+(const Recorded& a, const Recorded& b) {
  if (a.is_constant() && b.is_constant()) return Recorded::computed(a.value_ + b.value_);
  if (a.is(0)) return b;
  if (b.is(0)) return a;
  const auto [ca, xa] = a.shifted();
  const auto [cb, xb] = b.shifted();
  if ((ca != 0 && b.is_constant()) || (cb != 0 && a.is_constant()) || (ca != 0 && cb != 0)) {
    const Recorded constant = Recorded::computed((a.is_constant() ? a.value_ : ca) + (b.is_constant() ? b.value_ : cb));
    if (a.is_constant()) return constant + xb;
    if (b.is_constant()) return constant + xa;
    return constant + (xa + xb);
  }
  const auto [ka, ta] = a.scaled();
  const auto [kb, tb] = b.scaled();
  if (!a.is_constant() && ta.term_ == tb.term_) return Recorded::computed(ka + kb) * ta;
  if (kb < 0) return a - Recorded::computed(-kb) * tb;
  if (ka < 0) return b - Recorded::computed(-ka) * ta;
  return Recorded::of(recorded_in->add(a.term(), b.term()));
}

Recorded operator-(const Recorded& a, const Recorded& b) {
  if (b.is_constant()) return a + Recorded::computed(-b.value_);
  if (a.is(0)) return -b;
  const auto [ka, ta] = a.scaled();
  const auto [kb, tb] = b.scaled();
  if (!a.is_constant() && ta.term_ == tb.term_) return Recorded::computed(ka - kb) * ta;
  if (kb < 0) return a + Recorded::computed(-kb) * tb;
  if (ka < 0) return -(Recorded::computed(-ka) * ta + b);
  return Recorded::of(recorded_in->subtract(a.term(), b.term()));
}

Recorded operator-(const Recorded& a) {
  if (a.is_constant()) return Recorded::computed(-a.value_);
  const Node at = a.node();
  if (at.operation == Operation::subtract) return Recorded::of(at.of[1]) - Recorded::of(at.of[0]);
  const auto [k, x] = a.scaled();
  if (k != 1) return Recorded::computed(-k) * x;
  return Recorded::of(recorded_in->negate(a.term()));
}

Recorded operator*(const Recorded& a, const Recorded& b) {
  if (a.is_constant() && b.is_constant()) return Recorded::computed(a.value_ * b.value_);
  if (a.is(0) || b.is(0)) return Recorded();
  if (a.is(1)) return b;
  if (b.is(1)) return a;
  if (a.is(-1)) return -b;
  if (b.is(-1)) return -a;
  const auto [ka, xa] = a.scaled();
  const auto [kb, xb] = b.scaled();
  if (a.is_constant())
    return kb == 1 ? Recorded::of(recorded_in->multiply(a.term(), b.term())) : Recorded::computed(a.value_ * kb) * xb;
  if (b.is_constant()) return b * a;
  if (ka != 1 || kb != 1) return Recorded::computed(ka * kb) * (xa * xb);
  return Recorded::of(recorded_in->multiply(a.term(), b.term()));
}

Recorded operator/(const Recorded& a, const Recorded& b) {
  if (a.is_constant() && b.is_constant()) return Recorded::computed(a.value_ / b.value_);
  if (b.is_constant()) return Recorded::computed(1 / b.value_) * a;
  if (a.is(0)) return Recorded();
  const auto [ka, xa] = a.scaled();
  const auto [kb, xb] = b.scaled();
  if (!a.is_constant() && xa.term_ == xb.term_) return Recorded::computed(ka / kb);
  if (ka != 1 || kb != 1) return Recorded::computed(ka / kb) * (xa / xb);
  return Recorded::of(recorded_in->divide(a.term(), b.term()));
}

std::partial_ordering operator<=>(const Recorded& a, const Recorded& b) {
  if (a.is_constant() && b.is_constant()) return a.value_ <=> b.value_;
  if (b.is(0) && a.node().operation == Operation::sqrt) return std::partial_ordering::greater;
  if (a.is(0) && b.node().operation == Operation::sqrt) return std::partial_ordering::less;
  throw HiddenBranch();
}

double value_of(const Recorded& a) {
  if (!a.is_constant()) throw HiddenBranch();
  return a.value_;
}

Recorded Recorded::function(Operation operation, const Recorded& a) {
  if (a.is_constant()) return computed(expression::value_at(operation, a.value_));
  return Recorded::of(recorded_in->function(operation, a.term()));
}

Recorded sin(const Recorded& a) {
  if (!a.is_constant() && a.node().operation == Operation::negate)
    return -Recorded::function(Operation::sin, Recorded::of(a.node().of[0]));
  return Recorded::function(Operation::sin, a);
}
Recorded cos(const Recorded& a) {
  const bool is_negated = !a.is_constant() && a.node().operation == Operation::negate;
  return Recorded::function(Operation::cos, is_negated ? Recorded::of(a.node().of[0]) : a);
}
Recorded exp(const Recorded& a) { return Recorded::function(Operation::exp, a); }
Recorded sqrt(const Recorded& a) { return Recorded::function(Operation::sqrt, a); }
Recorded abs(const Recorded& a) { return Recorded::chosen(a, a, -a); }
Recorded atan2(const Recorded& y, const Recorded& x) {
  if (x.is_constant() && y.is_constant()) return Recorded::computed(std::atan2(y.value_, x.value_));
  return Recorded::of(recorded_in->function(Operation::atan2, y.term(), x.term()));
}

Recorded Recorded::power(const Recorded& a, const Recorded& b) {
  return Recorded::of(recorded_in->power(a.term(), b.term()));
}

Recorded Recorded::chosen(const Recorded& g, const Recorded& a, const Recorded& b) {
  if (g.is_constant()) return g.value_ > 0 ? a : b;
  return Recorded::of(recorded_in->choose(g.term(), a.term(), b.term()));
}

Recorded in_turn_of(double reference, const Recorded& q) {
  const Recorded at(reference);
  if (q.is_constant() && at.is_constant()) {
    const double turn = 2 * std::numbers::pi;
    return Recorded::computed(q.value_ + turn * std::round((reference - q.value_) / turn));
  }
  const Recorded from = q - at;
  return at + atan2(sin(from), cos(from));
}

// a = axis times the sine of the angle; at a = 0 it is the rotation vector itself.
Eigen::Matrix<Recorded, 3, 1> rotation_vector(const Eigen::Matrix<Recorded, 3, 3>& R) {
  const Eigen::Matrix<Recorded, 3, 1> a =
      Recorded(0.5) * Eigen::Matrix<Recorded, 3, 1>(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  const Recorded sine = sqrt(Recorded(a.squaredNorm()));
  const Recorded cosine = Recorded(0.5) * (R(0, 0) + R(1, 1) + R(2, 2) - Recorded(1));
  const Recorded factor = choose(sine, [&] { return atan2(sine, cosine) / sine; }, [] { return Recorded(1); });
  return factor * a;
}

}  // namespace gelenk::recording
