// SPDX-License-Identifier: BSD-3-Clause
// The functions of one argument in expressions, with their derivatives, for double, dual numbers and power series.
#pragma once

#include "expression/graph.h"
#include "math/dual.h"
#include "math/series.h"

namespace gelenk::expression {

// f, f' and f'' at a point.
struct Derivatives {
  double f = 0, df = 0, ddf = 0;
};

double value_at(Operation function, double x);
Derivatives derivatives_at(Operation function, double x);

inline double applied(Operation function, double x) { return value_at(function, x); }
inline Dual applied(Operation function, const Dual& x) {
  const Derivatives d = derivatives_at(function, x.value());
  return {d.f, d.df * x.derivatives()};
}
inline Series applied(Operation function, const Series& x) {
  const Derivatives d = derivatives_at(function, x[0]);
  return Series(Series::Coefficients{d.f, d.df * x[1], d.df * x[2] + d.ddf / 2 * x[1] * x[1]});
}

// x to the power of n, by repeated squaring.
template <class T>
T integer_power(T x, int n) {
  if (n < 0) return T(1) / integer_power(x, -n);
  T out(1);
  for (; n > 0; n /= 2) {
    if (n % 2 == 1) out = out * x;
    if (n > 1) x = x * x;
  }
  return out;
}

// x to the power of y, x >= 0.
inline double power(double x, double y) { return std::pow(x, y); }
Dual power(const Dual& x, const Dual& y);
Series power(const Series& x, const Series& y);

}  // namespace gelenk::expression
