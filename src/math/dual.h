// SPDX-License-Identifier: BSD-3-Clause
// Dual numbers: a value and its derivatives in several directions (forward-mode automatic differentiation; Griewank &
// Walther 2008, ch. 3). There are no expression templates, so that every expression has the type Dual and code written
// for double also compiles where results are returned, compared or passed to functions.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace gelenk {

// Number of directions differentiated at a time; their derivatives fit into a few vector registers.
inline constexpr int dual_directions = 8;

class Dual {
 public:
  using Directions = Eigen::Array<double, dual_directions, 1>;

  Dual() = default;
  Dual(double value) : value_(value) {}  // NOLINT(google-explicit-constructor): constants are numbers too
  Dual(double value, const Directions& derivatives) : value_(value), derivatives_(derivatives) {}

  double value() const { return value_; }
  const Directions& derivatives() const { return derivatives_; }
  Directions& derivatives() { return derivatives_; }

  Dual& operator+=(const Dual& b) {
    value_ += b.value_;
    derivatives_ += b.derivatives_;
    return *this;
  }
  Dual& operator-=(const Dual& b) {
    value_ -= b.value_;
    derivatives_ -= b.derivatives_;
    return *this;
  }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  friend Dual operator+(Dual a, const Dual& b) { return a += b; }
  friend Dual operator-(Dual a, const Dual& b) { return a -= b; }
  friend Dual operator-(const Dual& a) { return {-a.value_, -a.derivatives_}; }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value_ * b.value_, a.value_ * b.derivatives_ + b.value_ * a.derivatives_};
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const double quotient = a.value_ / b.value_;
    return {quotient, (a.derivatives_ - quotient * b.derivatives_) / b.value_};
  }

  // Comparisons use the values only.
  friend bool operator==(const Dual& a, const Dual& b) { return a.value_ == b.value_; }
  friend auto operator<=>(const Dual& a, const Dual& b) { return a.value_ <=> b.value_; }

  friend Dual sin(const Dual& a) { return {std::sin(a.value_), std::cos(a.value_) * a.derivatives_}; }
  friend Dual cos(const Dual& a) { return {std::cos(a.value_), -std::sin(a.value_) * a.derivatives_}; }
  friend Dual exp(const Dual& a) {
    const double value = std::exp(a.value_);
    return {value, value * a.derivatives_};
  }
  // At 0 the derivatives are set to 0, not infinity: callers treat a length of zero separately.
  friend Dual sqrt(const Dual& a) {
    const double root = std::sqrt(a.value_);
    return {root, root > 0 ? Directions(a.derivatives_ / (2 * root)) : Directions(Directions::Zero())};
  }
  friend Dual abs(const Dual& a) { return a.value_ < 0 ? -a : a; }
  friend Dual abs2(const Dual& a) { return a * a; }
  friend Dual atan2(const Dual& y, const Dual& x) {
    const double r2 = x.value_ * x.value_ + y.value_ * y.value_;
    return {std::atan2(y.value_, x.value_), (x.value_ * y.derivatives_ - y.value_ * x.derivatives_) / r2};
  }

 private:
  double value_ = 0;
  Directions derivatives_ = Directions::Zero();
};

inline double value_of(double x) { return x; }
inline double value_of(const Dual& x) { return x.value(); }

}  // namespace gelenk

template <>
struct Eigen::NumTraits<gelenk::Dual> : Eigen::NumTraits<double> {
  using Real = gelenk::Dual;
  using NonInteger = gelenk::Dual;
  using Nested = gelenk::Dual;
  using Literal = double;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 1 + gelenk::dual_directions,
    AddCost = 1 + gelenk::dual_directions,
    MulCost = 2 + 2 * gelenk::dual_directions
  };
};
