// SPDX-License-Identifier: BSD-3-Clause
// Adaptive Runge-Kutta methods of SUNDIALS' ARKODE, projected after each accepted step. One-step methods: a jump of
// the inputs costs them nothing but the derivative kept from the last step.
#pragma once

#include <arkode/arkode.h>

#include <vector>

#include "integrator/sundials_integrator.h"

namespace gelenk {

class ArkodeIntegrator : public SundialsIntegrator {
 public:
  ~ArkodeIntegrator() override;

 protected:
  using SundialsIntegrator::SundialsIntegrator;

  // Takes a stepper over, and sets what all methods share. The last one taken over is in use.
  void own(void* memory, double tolerance);
  // Goes on with another of the steppers owned, which is to try this step [s] first; 0: it finds one.
  void use(int stepper, double step);
  // Before the steps to `end`; t_ is their start.
  virtual void choose_stepper(double /*end*/) {}
  // Before each of these steps.
  virtual void reconsider_stepper() {}
  long attempts() const;     // of steps, by the stepper in use
  double next_step() const;  // s, likewise

  void* memory_ = nullptr;  // the stepper in use

 private:
  void prepare(double end) final;
  void begin(double end);
  Step make_step(double end) final;
  double reached() const final;
  bool steps_back() const final { return true; }
  void count() final;
  static int project(sunrealtype t, N_Vector y, void* self);

  std::vector<void*> steppers_;
};

}  // namespace gelenk
