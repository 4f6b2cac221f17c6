// SPDX-License-Identifier: BSD-3-Clause
// Where a function changes its sign: by inverse quadratic interpolation, or by halves where three points do not tell
// enough (Chandrupatla 1997, Advances in Engineering Software 28, 145-149).
#pragma once

#include <algorithm>
#include <cmath>

namespace gelenk {

class Bracket {
 public:
  // f has other signs at low < high.
  Bracket(double low, double f_low, double high, double f_high)
      : at_(high), f_at_(f_high), other_(low), f_other_(f_low), last_(low), f_last_(f_low) {}

  double low() const { return std::min(at_, other_); }
  double high() const { return std::max(at_, other_); }
  double width() const { return std::abs(other_ - at_); }

  // Where to look next, no nearer to an end than `nearest`, if the width allows it.
  double next(double nearest) const { return kept(at_ + share() * (other_ - at_), nearest); }
  // x, likewise.
  double kept(double x, double nearest) const {
    nearest = std::min(nearest, width() / 2);
    return std::clamp(x, low() + nearest, high() - nearest);
  }

  // f(x), low < x < high.
  void put(double x, double f) {
    if ((f < 0) == (f_at_ < 0)) {
      last_ = at_;
      f_last_ = f_at_;
    } else {
      last_ = other_;
      f_last_ = f_other_;
      other_ = at_;
      f_other_ = f_at_;
    }
    at_ = x;
    f_at_ = f;
  }

 private:
  // Of the way from at_ to other_.
  double share() const {
    const double a = at_ - other_;
    const double b = last_ - other_;
    const double xi = a / b;
    const double phi = (f_at_ - f_other_) / (f_last_ - f_other_);
    const bool tells = phi * phi < xi && (1 - phi) * (1 - phi) < 1 - xi;
    if (!tells) return 0.5;
    return f_at_ / (f_other_ - f_at_) * f_last_ / (f_other_ - f_last_) +
           (last_ - at_) / (other_ - at_) * f_at_ / (f_last_ - f_at_) * f_other_ / (f_last_ - f_other_);
  }

  double at_, f_at_;        // looked at last
  double other_, f_other_;  // of the other sign
  double last_, f_last_;    // beyond one of them; none: as other_
};

}  // namespace gelenk
