// SPDX-License-Identifier: BSD-3-Clause
// Adaptive Runge-Kutta methods of SUNDIALS' ARKODE, projected after each accepted step. One-step methods: a jump of
// the inputs costs them nothing but the derivative kept from the last step.
#pragma once

#include <arkode/arkode.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "integrator/sundials_integrator.h"

namespace gelenk {

class ArkodeIntegrator : public SundialsIntegrator {
 public:
  ~ArkodeIntegrator() override;
  bool will_have_history() const override { return false; }
  bool has_history() const override { return false; }
  void serialize(Archive& archive) override;

 protected:
  explicit ArkodeIntegrator(Equations& system);

  // Takes a stepper over, and sets what all methods share. The last one taken over is in use.
  void own(void* memory, double tolerance);
  // Goes on with another of the steppers owned, which is to try this step [s] first; 0: it finds one.
  void use(int stepper, double step);
  // Takes a stepper to (t_, y_) as if it had never made a step; its settings stay.
  virtual void reinitialize(void* memory) = 0;
  // s: that a stepper which has stopped where it was to will try next.
  virtual double next_step(std::size_t stepper) const;
  // Before the steps to `end`; t_ is their start.
  virtual void choose_stepper(double /*end*/) {}
  // Before each of these steps.
  virtual void reconsider_stepper() {}
  long attempts() const;  // of steps, by the stepper in use
  // Of its next step over the last one, at most.
  double growth(std::size_t stepper) const { return steppers_[stepper].growth; }
  double current_step() const;  // s: that it tries next; at a communication point the last one, cut short there

  void* memory_ = nullptr;  // the stepper in use
  double step_at_end_ = 0;  // s: current_step() where the last advance ended

 private:
  void prepare(double end) final;
  void begin(double end) final;
  static double current_step(void* memory);
  Step make_step(double end) final;
  double reached() const final;
  Counts count() final;
  static int project(sunrealtype t, N_Vector y, void* self);

  struct Stepper {
    void* memory = nullptr;
    bool stopped = false;              // its last step ended where it was to stop
    bool used = false;                 // has made steps: the next one may not be as much longer as a first one's next
    std::optional<double> first_step;  // s, to be tried first; 0: it finds one
    double last_step = 0;              // s, before that one; 0: of no concern
    double growth = 1;                 // of the next step over the last one
  };
  std::size_t in_use() const { return std::ranges::find(steppers_, memory_, &Stepper::memory) - steppers_.begin(); }

  std::vector<Stepper> steppers_;
};

}  // namespace gelenk
