// SPDX-License-Identifier: BSD-3-Clause
#include "expression/functions.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace gelenk::expression {

double value_at(Operation function, double x) {
  switch (function) {
    case Operation::sin:
      return std::sin(x);
    case Operation::cos:
      return std::cos(x);
    case Operation::tan:
      return std::tan(x);
    case Operation::asin:
      return std::asin(x);
    case Operation::acos:
      return std::acos(x);
    case Operation::atan:
      return std::atan(x);
    case Operation::sinh:
      return std::sinh(x);
    case Operation::cosh:
      return std::cosh(x);
    case Operation::tanh:
      return std::tanh(x);
    case Operation::asinh:
      return std::asinh(x);
    case Operation::acosh:
      return std::acosh(x);
    case Operation::atanh:
      return std::atanh(x);
    case Operation::exp:
      return std::exp(x);
    case Operation::log:
      return std::log(x);
    case Operation::log10:
      return std::log10(x);
    case Operation::sqrt:
      return std::sqrt(x);
    case Operation::cbrt:
      return std::cbrt(x);
    case Operation::erf:
      return std::erf(x);
    default:
      return std::numeric_limits<double>::quiet_NaN();
  }
}

Derivatives derivatives_at(Operation function, double x) {
  const double f = value_at(function, x);
  switch (function) {
    case Operation::sin:
      return {f, std::cos(x), -f};
    case Operation::cos:
      return {f, -std::sin(x), -f};
    case Operation::tan:
      return {f, 1 + f * f, 2 * f * (1 + f * f)};
    case Operation::asin: {
      const double c = 1 / std::sqrt((1 - x) * (1 + x));
      return {f, c, x * c * c * c};
    }
    case Operation::acos: {
      const double c = -1 / std::sqrt((1 - x) * (1 + x));
      return {f, c, x * c * c * c};
    }
    case Operation::atan: {
      const double c = 1 / (1 + x * x);
      return {f, c, -2 * x * c * c};
    }
    case Operation::sinh:
      return {f, std::cosh(x), f};
    case Operation::cosh:
      return {f, std::sinh(x), f};
    case Operation::tanh: {
      const double c = std::cosh(x);
      const double df = 1 / (c * c);
      return {f, df, -2 * f * df};
    }
    case Operation::asinh: {
      const double c = 1 / std::sqrt(1 + x * x);
      return {f, c, -x * c * c * c};
    }
    case Operation::acosh: {
      const double c = 1 / std::sqrt((x - 1) * (x + 1));
      return {f, c, -x * c * c * c};
    }
    case Operation::atanh: {
      const double c = 1 / ((1 - x) * (1 + x));
      return {f, c, 2 * x * c * c};
    }
    case Operation::exp:
      return {f, f, f};
    case Operation::log:
      return {f, 1 / x, -1 / (x * x)};
    case Operation::log10:
      return {f, std::numbers::log10e / x, -std::numbers::log10e / (x * x)};
    case Operation::sqrt:
      return {f, 1 / (2 * f), -1 / (4 * f * x)};
    case Operation::cbrt:
      return {f, 1 / (3 * f * f), -2 / (9 * f * f * x)};
    case Operation::erf: {
      const double df = 2 * std::numbers::inv_sqrtpi * std::exp(-x * x);
      return {f, df, -2 * x * df};
    }
    default:
      return {f, f, f};
  }
}

namespace {

// A derivative, which may be infinite where x = 0, times a rate: a rate of 0 leaves nothing.
double along(double derivative, double rate) { return rate == 0 ? 0 : derivative * rate; }

// The derivative of x^y with respect to y; 0 at x = 0, where x^y is 0 for all y > 0.
double by_exponent(double value, double x) { return value == 0 ? 0 : value * std::log(x); }

}  // namespace

Dual power(const Dual& x, const Dual& y) {
  const double value = std::pow(x.value(), y.value());
  const double by_base = y.value() * std::pow(x.value(), y.value() - 1);
  return {value, by_base * x.derivatives() + by_exponent(value, x.value()) * y.derivatives()};
}

Series power(const Series& x, const Series& y) {
  const double value = std::pow(x[0], y[0]);
  const double by_base = y[0] * std::pow(x[0], y[0] - 1);
  const double by_both = std::pow(x[0], y[0] - 1) * (1 + y[0] * std::log(x[0]));
  const double twice_by_base = y[0] * (y[0] - 1) * std::pow(x[0], y[0] - 2);
  const double e = by_exponent(value, x[0]);
  const double twice_by_exponent = value == 0 ? 0 : e * std::log(x[0]);
  return Series(Series::Coefficients{value, along(by_base, x[1]) + e * y[1],
                                     along(by_base, x[2]) + e * y[2] + along(twice_by_base, x[1] * x[1]) / 2 +
                                         along(by_both, x[1] * y[1]) + twice_by_exponent * y[1] * y[1] / 2});
}

}  // namespace gelenk::expression
