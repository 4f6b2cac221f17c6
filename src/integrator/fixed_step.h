// SPDX-License-Identifier: BSD-3-Clause
// The way from one communication point to the next in equal steps, each projected, which fixed-step methods share.
#pragma once

#include <vector>

#include "integrator/integrator.h"

namespace gelenk {

class FixedStep : public Integrator {
 public:
  void restart(double t, const double* y) override;
  double advance(double end, double* y) final;

 protected:
  FixedStep(Equations& system, const IntegratorOptions& options);

  // Takes y_ from t to t + h, not yet projected.
  virtual void make_step(double t, double h) = 0;
  // k_ = f(t, y). Throws IntegrationError.
  void evaluate(double t, const double* y);

  Equations& system_;
  int n_;
  std::vector<double> y_, k_;

 private:
  double step_;
  double t_ = 0;
};

}  // namespace gelenk
