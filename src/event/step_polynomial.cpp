// SPDX-License-Identifier: BSD-3-Clause
#include "event/step_polynomial.h"

#include <algorithm>
#include <cmath>

namespace gelenk {
namespace {

// Relative to 1 in natural units or to a component: the largest part of it at the middle of a step that its cubic
// lacks. That is h^4 y'''' / 384; the next term is smaller by a tenth of (1e-11 * 384)^(1/4) = 0.008. It also bounds
// the error of the step itself, which the end of a shorter step would not have.
constexpr double most_lacking = 1e-11;
// Of s^2 (1 - s)^2: its largest value, and its rate at a quarter.
constexpr double bump_height = 1.0 / 16;
constexpr double rate_at_quarter = 3.0 / 16;
constexpr double quarter = 0.25;

bool is_negligible(double bump, double y0, double y1) {
  return std::abs(bump) * bump_height <= most_lacking * std::max({1.0, std::abs(y0), std::abs(y1)});
}

}  // namespace

bool StepPolynomial::set(EventSource& source, double t0, const double* y0, double t1, const double* y1) {
  std::copy_n(y0, y0_.size(), y0_.begin());
  std::copy_n(y1, y1_.size(), y1_.begin());
  t0_ = t0;
  h_ = t1 - t0;
  if (!source.rates(t1, y1_.data(), rate1_.data()) || !source.rates(t0, y0_.data(), rate0_.data())) return false;
  integrates_ = consists_of_coordinates_and_rates();
  return find_bumps(source);
}

bool StepPolynomial::consists_of_coordinates_and_rates() const {
  const std::size_t n = y0_.size() / 2;
  const auto half = static_cast<std::ptrdiff_t>(n);
  return 2 * n == y0_.size() && std::equal(rate0_.begin(), rate0_.begin() + half, y0_.begin() + half) &&
         std::equal(rate1_.begin(), rate1_.begin() + half, y1_.begin() + half);
}

// Not from the change of the coordinates, which is the integral of their rates: what a method of order 4 errs there is
// as large as what the cubics lack.
bool StepPolynomial::find_bumps(EventSource& source) {
  std::ranges::fill(bump_, 0);
  const double t = t0_ + quarter * h_;
  std::vector<double>& y = work_;
  at(t, y.data());
  source.normalize(y.data());
  if (!source.rates(t, y.data(), bump_.data())) return false;
  for (std::size_t k = 0; k < y.size(); ++k) {
    const double rate = 1.125 * (y1_[k] - y0_[k]) + h_ * (0.1875 * rate0_[k] - 0.3125 * rate1_[k]);
    bump_[k] = (h_ * bump_[k] - rate) / rate_at_quarter;
    if (!is_negligible(bump_[k], y0_[k], y1_[k])) return false;
  }
  return true;
}

// Of component k from the start of the step.
double StepPolynomial::integral(std::size_t k, double s) const {
  const double s2 = s * s;
  return h_ * s *
         (y0_[k] * (1 + s2 * (s / 2 - 1)) + y1_[k] * s2 * (1 - s / 2) +
          h_ * rate0_[k] * s * (0.5 + s * (s / 4 - 2.0 / 3)) + h_ * rate1_[k] * s2 * (s / 4 - 1.0 / 3) +
          bump_[k] * s2 * (1.0 / 3 + s * (s / 5 - 0.5)));
}

void StepPolynomial::at(double t, double* y) const {
  const std::size_t n = integrates_ ? y0_.size() / 2 : 0;
  const double s = (t - t0_) / h_;
  const double r = 1 - s;
  for (std::size_t k = 0; k < n; ++k) y[k] = y0_[k] + integral(n + k, s);
  for (std::size_t k = n; k < y0_.size(); ++k) {
    y[k] = r * r * (1 + 2 * s) * y0_[k] + s * s * (3 - 2 * s) * y1_[k] +
           s * r * (h_ * (r * rate0_[k] - s * rate1_[k]) + bump_[k] * s * r);
  }
}

}  // namespace gelenk
