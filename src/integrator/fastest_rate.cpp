// SPDX-License-Identifier: BSD-3-Clause
#include "integrator/fastest_rate.h"

#include <algorithm>
#include <cmath>

namespace gelenk {
namespace {

constexpr int iterations = 8;    // at most,
constexpr double settled = 0.1;  // or until it does not change by more, relatively

}  // namespace

FastestRate::FastestRate(Equations& system)
    : system_(system), n_(system.size()), direction_(n_), beside_(n_), f_(n_), f_beside_(n_) {
  for (int i = 0; i < n_; ++i) direction_[i] = 1 + 0.3 * i / n_;
}

double FastestRate::at(double t, const double* y) {
  if (!system_.rhs(t, y, f_.data())) return 0;
  double size = 0;
  for (int k = 0; k < n_; ++k) size += y[k] * y[k];
  const double h = 1e-7 * std::sqrt(1 + size);
  double rate = 0;
  for (int i = 0; i < iterations; ++i) {
    double length = 0;
    for (const double x : direction_) length += x * x;
    length = std::sqrt(length);
    if (!(length > 0 && std::isfinite(length))) break;
    for (int k = 0; k < n_; ++k) beside_[k] = y[k] + h * direction_[k] / length;
    if (!system_.rhs(t, beside_.data(), f_beside_.data())) break;
    const double before = rate;
    rate = 0;
    for (int k = 0; k < n_; ++k) {
      direction_[k] = (f_beside_[k] - f_[k]) / h;
      rate += direction_[k] * direction_[k];
    }
    rate = std::sqrt(rate);
    if (std::abs(rate - before) < settled * rate) break;
  }
  if (!(rate > 0 && std::isfinite(rate))) std::ranges::fill(direction_, 1.0);
  return rate;
}

}  // namespace gelenk
