// SPDX-License-Identifier: BSD-3-Clause
// The improved Euler method, fixed steps, projected after each: q displaced by h (v + h/2 vdot), v += h vdot, one
// evaluation per step. Exact for constant acceleration. Of order 1: in a step positions have errors of h^3 but
// velocities of h^2 (h^2/2 times the rate of the acceleration), which sum up to h over the run, and positions follow
// the velocities.
#include <vector>

#include "integrator/fixed_step.h"

namespace gelenk {
namespace {

class Euler final : public FixedStep {
 public:
  Euler(Equations& system, const IntegratorOptions& options)
      : FixedStep(system, options), nq_(system.coordinates()), dq_(n_ - nq_) {}

 private:
  void make_step(double t, double h) override {
    evaluate(t, y_.data());
    double* v = y_.data() + nq_;
    const double* vdot = k_.data() + nq_;
    for (int i = 0; i < n_ - nq_; ++i) {
      dq_[i] = h * (v[i] + h / 2 * vdot[i]);
      v[i] += h * vdot[i];
    }
    system_.displace(y_.data(), dq_.data());
  }

  int nq_;
  std::vector<double> dq_;  // displacement along the velocities (nv)
};

}  // namespace

std::unique_ptr<Integrator> make_euler(Equations& system, const IntegratorOptions& options) {
  return std::make_unique<Euler>(system, options);
}

}  // namespace gelenk
