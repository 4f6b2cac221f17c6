// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/fastest_rate.h"

#include <algorithm>
#include <cmath>

namespace gelenk {
namespace {

constexpr int power_iterations = 8;
constexpr double rate_tolerance = 0.1;  // change of the estimate at which the iteration ends

}  // namespace

FastestRate::FastestRate(Equations& system)
    : system_(system), n_(system.size()), direction_(n_), perturbed_(n_), f_(n_), f_perturbed_(n_) {
  for (int i = 0; i < n_; ++i) direction_[i] = 1 + 0.3 * i / n_;
}

double FastestRate::at(double t, const double* y) {
  if (!system_.rhs(t, y, f_.data())) return 0;
  double size = 0;
  for (int k = 0; k < n_; ++k) size += y[k] * y[k];
  const double h = 1e-7 * std::sqrt(1 + size);
  double rate = 0;
  for (int i = 0; i < power_iterations; ++i) {
    double length = 0;
    for (const double x : direction_) length += x * x;
    length = std::sqrt(length);
    if (!(length > 0 && std::isfinite(length))) break;
    for (int k = 0; k < n_; ++k) perturbed_[k] = y[k] + h * direction_[k] / length;
    if (!system_.rhs(t, perturbed_.data(), f_perturbed_.data())) break;
    const double before = rate;
    rate = 0;
    for (int k = 0; k < n_; ++k) {
      direction_[k] = (f_perturbed_[k] - f_[k]) / h;
      rate += direction_[k] * direction_[k];
    }
    rate = std::sqrt(rate);
    if (std::abs(rate - before) < rate_tolerance * rate) break;
  }
  if (!(rate > 0 && std::isfinite(rate))) std::ranges::fill(direction_, 1.0);
  return rate;
}

}  // namespace gelenk
