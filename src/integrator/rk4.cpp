// SPDX-License-Identifier: BSD-3-Clause
// The classical Runge-Kutta method of order 4 (Kutta 1901), fixed steps, projected after each.
#include <algorithm>
#include <vector>

#include "integrator/fixed_step.h"

namespace gelenk {
namespace {

class Rk4 final : public FixedStep {
 public:
  Rk4(Equations& system, const IntegratorOptions& options) : FixedStep(system, options), stage_(n_), sum_(n_) {}

 private:
  void make_step(double t, double h) override {
    evaluate(t, y_.data());
    std::ranges::copy(k_, sum_.begin());
    for (const double fraction : {0.5, 0.5, 1.0}) {
      for (int i = 0; i < n_; ++i) stage_[i] = y_[i] + fraction * h * k_[i];
      evaluate(t + fraction * h, stage_.data());
      const double weight = fraction == 0.5 ? 2 : 1;
      for (int i = 0; i < n_; ++i) sum_[i] += weight * k_[i];
    }
    for (int i = 0; i < n_; ++i) y_[i] += h / 6 * sum_[i];
  }

  std::vector<double> stage_, sum_;
};

}  // namespace

std::unique_ptr<Integrator> make_rk4(Equations& system, const IntegratorOptions& options) {
  return std::make_unique<Rk4>(system, options);
}

}  // namespace gelenk
