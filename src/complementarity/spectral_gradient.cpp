// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/spectral_gradient.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "complementarity/shift.h"

namespace gelenk {
namespace {

using Eigen::Index;

constexpr double min_length = 1e-10, max_length = 1e10;  // of the spectral step, as published
constexpr double sufficient_decrease = 1e-4;             // fraction of the linear prediction (Armijo)
constexpr int renewal_interval = 50;                     // of u = G x + b: updates add rounding errors

}  // namespace

// d <- P_K(x - length g) - x
void SpectralGradient::direction(ConeIteration& at, double length) {
  const ConeVector x = at.x();
  ConeVector d(d_, at.size());
  d = x - length * ConeVector(gradient_, at.size());
  at.project_all(d_, d_);
  d -= x;
}

void SpectralGradient::remember(double value) {
  values_[next_] = value;
  next_ = (next_ + 1) % window;
}

// The fraction of the step d after which the objective is sufficiently below the largest of the last values (Grippo,
// Lampariello & Lucidi 1986). decrease = g . d < 0, curvature = d . G d.
double SpectralGradient::step_fraction(double decrease, double curvature) {
  const double present = values_[(next_ + window - 1) % window];
  const double reference = *std::max_element(values_, values_ + window);
  double fraction = 1;
  for (;;) {
    const double change = fraction * decrease + 0.5 * fraction * fraction * curvature;
    if (present + change <= reference + sufficient_decrease * fraction * decrease || fraction < 1e-10) {
      remember(present + change);
      return fraction;
    }
    const double minimum = -decrease / curvature;  // of the parabola
    fraction = std::clamp(minimum, 0.1 * fraction, 0.9 * fraction);
  }
}

void SpectralGradient::run(ConeIteration& at, int max_steps) {
  const Index n = at.size();
  reserve(n);
  for (double** piece : {&shift_, &gradient_, &d_, &Gd_}) *piece = memory_.take(n);
  ConeVector gradient(gradient_, n), d(d_, n), Gd(Gd_, n), shift(shift_, n);
  FrozenShift frozen(at, shift_, d_);
  std::fill_n(values_, window, -std::numeric_limits<double>::infinity());
  remember(0);
  double length = 1;
  for (int k = 0; k < max_steps; ++k) {
    gradient = at.u() + shift;
    direction(at, length);
    const double square = d.squaredNorm();
    if (square == 0) return;
    // At most -|d|^2 / length, by the properties of projections; near the solution g . d is the small difference of
    // large numbers.
    const double decrease = std::min(gradient.dot(d), -square / length);
    at.multiply(d_, Gd_);
    const double curvature = d.dot(Gd);
    const double fraction = step_fraction(decrease, curvature);
    at.x() += fraction * d;
    at.u() += fraction * Gd;
    if ((k + 1) % renewal_interval == 0) at.update_velocity();
    // Barzilai & Borwein's two quotients in turn.
    const double quotient = k % 2 == 0 ? square / curvature : curvature / Gd.squaredNorm();
    length = std::isfinite(quotient) && quotient > 0 ? std::clamp(quotient, min_length, max_length) : max_length;
    if (!at.advance()) return;
    if (frozen.renew_if_solved()) {
      std::fill_n(values_, window, -std::numeric_limits<double>::infinity());
      remember(0);
    }
  }
}

namespace {

class SpectralSolver final : public IterativeConeSolver {
  void reserve(ConeIteration& at) override { method_.reserve(at.size()); }
  void run(ConeIteration& at) override {
    while (!at.done()) {
      const double before = at.best_residual();
      method_.run(at, 1000);
      if (!at.done() && !(at.best_residual() < before)) return;
    }
  }
  SpectralGradient method_;
};

}  // namespace

std::unique_ptr<ConeSolver> make_spectral_cone_solver() { return std::make_unique<SpectralSolver>(); }

}  // namespace gelenk
