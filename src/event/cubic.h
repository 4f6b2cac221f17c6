// SPDX-License-Identifier: BSD-3-Clause
// A function over a step, interpolated from its values and rates at both ends (cubic Hermite polynomial).
#pragma once

#include <cmath>

namespace gelenk {

// The argument s is the fraction of the step, 0 to 1. A straight line if a rate is not finite.
class Cubic {
 public:
  // Rates are derivatives with respect to s.
  Cubic(double g0, double rate0, double g1, double rate1) : g0_(g0), g1_(g1), rate0_(rate0), rate1_(rate1) {
    if (std::isfinite(rate0) && std::isfinite(rate1)) return;
    rate0_ = rate1_ = g1 - g0;
  }

  double value(double s) const {
    const double r = 1 - s;
    return r * r * (1 + 2 * s) * g0_ + s * s * (3 - 2 * s) * g1_ + s * r * (r * rate0_ - s * rate1_);
  }
  // The zero; the ends must have different signs.
  double zero() const {
    return bisect([&](double s) { return (value(s) < 0) == (g0_ < 0); });
  }
  // Whether there is an extremum inside the step, and where.
  bool has_extremum() const { return rate0_ * rate1_ < 0; }
  double extremum() const {
    return bisect([&](double s) { return (rate(s) < 0) == (rate0_ < 0); });
  }

 private:
  double rate(double s) const {
    const double fall = 6 * (g0_ - g1_);
    return (1 - s) * (rate0_ - s * (fall + 3 * (rate0_ + rate1_))) + s * rate1_;
  }
  // Bisection for the point up to which `holds` is true; it is true at 0.
  template <class Holds>
  static double bisect(Holds holds) {
    double low = 0;
    double high = 1;
    for (int k = 0; k < 50; ++k) {
      const double middle = (low + high) / 2;
      (holds(middle) ? low : high) = middle;
    }
    return low;
  }

  double g0_, g1_, rate0_, rate1_;
};

}  // namespace gelenk
