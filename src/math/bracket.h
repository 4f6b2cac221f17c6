// SPDX-License-Identifier: BSD-3-Clause
// Bracketed root finding by inverse quadratic interpolation where it is reliable, and by bisection elsewhere
// (Chandrupatla 1997, Advances in Engineering Software 28, 145-149).
#pragma once

#include <algorithm>
#include <cmath>

namespace gelenk {

class Bracket {
 public:
  // f_low and f_high, the function values at low < high, have opposite signs.
  Bracket(double low, double f_low, double high, double f_high)
      : latest_(high), f_latest_(f_high), opposite_(low), f_opposite_(f_low), third_(low), f_third_(f_low) {}

  double low() const { return std::min(latest_, opposite_); }
  double high() const { return std::max(latest_, opposite_); }
  double width() const { return std::abs(opposite_ - latest_); }

  // Returns the point at which to evaluate next, at least `margin` away from both ends or, if the bracket is too narrow
  // for this, its center.
  double next(double margin) const { return clamped(latest_ + fraction() * (opposite_ - latest_), margin); }
  // Returns x moved into the bracket with the same margin.
  double clamped(double x, double margin) const {
    margin = std::min(margin, width() / 2);
    return std::clamp(x, low() + margin, high() - margin);
  }

  // Shrinks the bracket by the function value f at x, low < x < high.
  void update(double x, double f) {
    if ((f < 0) == (f_latest_ < 0)) {
      third_ = latest_;
      f_third_ = f_latest_;
    } else {
      third_ = opposite_;
      f_third_ = f_opposite_;
      opposite_ = latest_;
      f_opposite_ = f_latest_;
    }
    latest_ = x;
    f_latest_ = f;
  }

 private:
  // Position of the next point as a fraction of the way from latest_ to opposite_.
  double fraction() const {
    const double a = latest_ - opposite_;
    const double b = third_ - opposite_;
    const double xi = a / b;
    const double phi = (f_latest_ - f_opposite_) / (f_third_ - f_opposite_);
    const bool can_interpolate = phi * phi < xi && (1 - phi) * (1 - phi) < 1 - xi;
    if (!can_interpolate) return 0.5;
    return f_latest_ / (f_opposite_ - f_latest_) * f_third_ / (f_opposite_ - f_third_) +
           (third_ - latest_) / (opposite_ - latest_) * f_latest_ / (f_third_ - f_latest_) * f_opposite_ /
               (f_third_ - f_opposite_);
  }

  double latest_, f_latest_;      // end of the bracket that was evaluated last
  double opposite_, f_opposite_;  // other end, where the function has the opposite sign
  double third_, f_third_;        // previous end, outside the bracket; at first the same as opposite_
};

}  // namespace gelenk
