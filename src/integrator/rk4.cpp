// SPDX-License-Identifier: BSD-3-Clause
// The classical Runge-Kutta method of order 4 (Kutta 1901), fixed steps, projected after each.
#include <algorithm>
#include <cmath>
#include <vector>

#include "integrator/integrator.h"

namespace gelenk {
namespace {

class Rk4 final : public Integrator {
 public:
  Rk4(OdeSystem& system, const IntegratorOptions& options)
      : system_(system), step_(options.step), n_(system.size()), y_(n_), stage_(n_), k_(n_), sum_(n_) {}

  void restart(double t, const double* y) override {
    t_ = t;
    std::copy(y, y + n_, y_.begin());
  }

  void advance(double end, double* y) override {
    // As many equal steps as are needed, none longer than the step; 1e-9 of a step is rounding of the times.
    const double start = t_;
    const long count = std::max(1L, static_cast<long>(std::ceil((end - start) / step_ - 1e-9)));
    const double h = (end - start) / static_cast<double>(count);
    for (long i = 0; i < count; ++i) {
      make_step(start + static_cast<double>(i) * h, h);
      t_ = i + 1 == count ? end : start + static_cast<double>(i + 1) * h;
      if (!system_.project(t_, y_.data())) throw IntegrationError(at_time(t_) + "the loops could not be closed again");
      system_.accepted(t_, y_.data());
      ++steps_;
    }
    std::ranges::copy(y_, y);
  }

 private:
  void make_step(double t, double h) {
    evaluate(t, y_.data());
    std::ranges::copy(k_, sum_.begin());
    for (const double part : {0.5, 0.5, 1.0}) {
      for (int i = 0; i < n_; ++i) stage_[i] = y_[i] + part * h * k_[i];
      evaluate(t + part * h, stage_.data());
      const double weight = part == 0.5 ? 2 : 1;
      for (int i = 0; i < n_; ++i) sum_[i] += weight * k_[i];
    }
    for (int i = 0; i < n_; ++i) y_[i] += h / 6 * sum_[i];
  }

  void evaluate(double t, const double* y) {
    if (!system_.rhs(t, y, k_.data())) throw IntegrationError(at_time(t) + "the accelerations are not finite");
  }

  OdeSystem& system_;
  double step_;
  int n_;
  double t_ = 0;
  std::vector<double> y_, stage_, k_, sum_;
};

}  // namespace

std::unique_ptr<Integrator> make_rk4(OdeSystem& system, const IntegratorOptions& options) {
  return std::make_unique<Rk4>(system, options);
}

}  // namespace gelenk
