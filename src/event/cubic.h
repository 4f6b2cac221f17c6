// SPDX-License-Identifier: BSD-3-Clause
// A function over a step, as far as its values and rates at both ends tell (Hermite).
#pragma once

#include <cmath>

namespace gelenk {

// At shares s of the step, 0 to 1. The straight line, where a rate is no number.
class Cubic {
 public:
  // Rates are by share of the step.
  Cubic(double g0, double rate0, double g1, double rate1) : g0_(g0), g1_(g1), rate0_(rate0), rate1_(rate1) {
    if (std::isfinite(rate0) && std::isfinite(rate1)) return;
    rate0_ = rate1_ = g1 - g0;
  }

  double value(double s) const {
    const double r = 1 - s;
    return r * r * (1 + 2 * s) * g0_ + s * s * (3 - 2 * s) * g1_ + s * r * (r * rate0_ - s * rate1_);
  }
  // Between ends of different sign.
  double zero() const {
    return halved([&](double s) { return (value(s) < 0) == (g0_ < 0); });
  }
  // Whether it turns once between; and where, if it does.
  bool turns() const { return rate0_ * rate1_ < 0; }
  double turning_point() const {
    return halved([&](double s) { return (rate(s) < 0) == (rate0_ < 0); });
  }

 private:
  double rate(double s) const {
    const double fall = 6 * (g0_ - g1_);
    return (1 - s) * (rate0_ - s * (fall + 3 * (rate0_ + rate1_))) + s * rate1_;
  }
  // Where what holds at 0 begins not to.
  template <class Holds>
  static double halved(Holds holds) {
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
