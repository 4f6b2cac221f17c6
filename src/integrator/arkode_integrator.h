// SPDX-License-Identifier: BSD-3-Clause
// Adaptive Runge-Kutta methods of SUNDIALS' ARKODE, projected after each accepted step. One-step methods: a jump of
// the inputs costs them nothing but the derivative kept from the last step.
#pragma once

#include <arkode/arkode.h>

#include "integrator/sundials_integrator.h"

namespace gelenk {

class ArkodeIntegrator : public SundialsIntegrator {
 public:
  ~ArkodeIntegrator() override { ARKodeFree(&memory_); }

 protected:
  using SundialsIntegrator::SundialsIntegrator;

  // Takes the stepper over; sets what all methods share.
  void own(void* memory, double tolerance);

  void* memory_ = nullptr;

 private:
  void prepare(double end) final;
  Step make_step(double end) final;
  double reached() const final;
  void count() final;
  static int project(sunrealtype t, N_Vector y, void* self);
};

}  // namespace gelenk
