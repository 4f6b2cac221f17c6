// SPDX-License-Identifier: BSD-3-Clause
// Functions of time as truncated power series x0 + x1 t + x2 t^2 (Griewank & Walther 2008, ch. 13). The k-th time
// derivative at t = 0 is k! x_k.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

namespace gelenk {

inline constexpr int series_order = 2;

class Series {
 public:
  using Coefficients = std::array<double, series_order + 1>;

  Series() = default;
  Series(double value) : x_{value} {}  // NOLINT(google-explicit-constructor): constants are numbers too
  explicit Series(const Coefficients& x) : x_(x) {}

  double value() const { return x_[0]; }
  double operator[](int k) const { return x_[k]; }
  double& operator[](int k) { return x_[k]; }

  Series& operator+=(const Series& b) {
    for (int k = 0; k <= series_order; ++k) x_[k] += b.x_[k];
    return *this;
  }
  Series& operator-=(const Series& b) {
    for (int k = 0; k <= series_order; ++k) x_[k] -= b.x_[k];
    return *this;
  }
  Series& operator*=(const Series& b) { return *this = *this * b; }
  Series& operator/=(const Series& b) { return *this = *this / b; }

  friend Series operator+(Series a, const Series& b) { return a += b; }
  friend Series operator-(Series a, const Series& b) { return a -= b; }
  friend Series operator-(const Series& a) { return Series(Coefficients{-a[0], -a[1], -a[2]}); }
  friend Series operator*(const Series& a, const Series& b) {
    return Series(Coefficients{a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[0] * b[2] + a[1] * b[1] + a[2] * b[0]});
  }
  friend Series operator/(const Series& a, const Series& b) {
    const double q0 = a[0] / b[0];
    const double q1 = (a[1] - q0 * b[1]) / b[0];
    return Series(Coefficients{q0, q1, (a[2] - q0 * b[2] - q1 * b[1]) / b[0]});
  }

  // Comparisons use the values only.
  friend bool operator==(const Series& a, const Series& b) { return a[0] == b[0]; }
  friend auto operator<=>(const Series& a, const Series& b) { return a[0] <=> b[0]; }

  friend Series sin(const Series& a) { return a.composed(std::sin(a[0]), std::cos(a[0]), -std::sin(a[0])); }
  friend Series cos(const Series& a) { return a.composed(std::cos(a[0]), -std::sin(a[0]), -std::cos(a[0])); }
  friend Series exp(const Series& a) {
    const double value = std::exp(a[0]);
    return a.composed(value, value, value);
  }
  // At 0 the derivatives are set to 0, not infinity: callers treat a length of zero separately.
  friend Series sqrt(const Series& a) {
    const double root = std::sqrt(a[0]);
    if (!(root > 0)) return root;
    return a.composed(root, 1 / (2 * root), -1 / (4 * root * a[0]));
  }
  friend Series abs(const Series& a) { return a[0] < 0 ? -a : a; }
  friend Series abs2(const Series& a) { return a * a; }
  // Rotated by the angle at t = 0, which leaves the arc tangent of a small quotient z: z - z^3 / 3 ...
  friend Series atan2(const Series& y, const Series& x) {
    const Series z = (x[0] * y - y[0] * x) / (x[0] * x + y[0] * y);
    return z + std::atan2(y[0], x[0]);
  }

 private:
  // The composition f(x(t)) from f, f' and f'' at x0.
  Series composed(double f, double df, double ddf) const {
    return Series(Coefficients{f, df * x_[1], df * x_[2] + ddf / 2 * x_[1] * x_[1]});
  }

  Coefficients x_{};
};

inline double value_of(const Series& x) { return x.value(); }

}  // namespace gelenk

template <>
struct Eigen::NumTraits<gelenk::Series> : Eigen::NumTraits<double> {
  using Real = gelenk::Series;
  using NonInteger = gelenk::Series;
  using Nested = gelenk::Series;
  using Literal = double;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 3,
    AddCost = 3,
    MulCost = 9
  };
};
