// SPDX-License-Identifier: BSD-3-Clause
// Base class of the adaptive Runge-Kutta methods of SUNDIALS' ARKODE, projected after each accepted step. One-step
// methods: a jump of the inputs invalidates only the derivative kept from the last step.
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
  void inputs_touched() override { touched_ = true; }
  bool will_have_history() const override { return false; }
  bool has_history() const override { return false; }
  void serialize(Archive& archive) override;

 protected:
  ArkodeIntegrator(Equations& system, const EventSource::SlowSliding& slow_sliding);

  // Takes ownership of a stepper, applies the common settings, and makes it the one in use.
  void adopt(void* memory, double tolerance);
  // Continues with another stepper, which tries this step [s] first; 0: it chooses one.
  void use(int stepper, double step);
  // Evaluates ydot = f(t, y), unless a saved state that was restored has it.
  static int rhs(sunrealtype t, N_Vector y, N_Vector ydot, void* self);
  // Resets a stepper to (t_, y_) as if it had made no steps; its settings remain.
  virtual void reinitialize(void* memory) = 0;
  // s: the step that a stepper will try after it has reached its stop time.
  virtual double step_after_stop(std::size_t stepper) const;
  // Called before the steps to `end`; t_ is their start.
  virtual void choose_stepper(double /*end*/) {}
  // Called before each of these steps.
  virtual void reconsider_stepper() {}
  long attempts() const;  // number of step attempts of the stepper in use
  // Limit on the ratio of its next step to the last one.
  double growth(std::size_t stepper) const { return steppers_[stepper].growth; }
  double current_step() const;  // s: next step to be tried; at a communication point the last one, cut short there

  void* memory_ = nullptr;  // the stepper in use
  double step_at_end_ = 0;  // s: current_step() at the end of the last advance

 private:
  // Whether the last stage of a step of the stepper in use is the first one of the next step.
  virtual bool keeps_derivative() const { return false; }
  void before_restart() final;
  void prepare(double end) final;
  void begin(double end) final;
  static double current_step(void* memory);
  Step make_step(double end) final;
  void set_stop_time(double end) final;
  double reached() const final;
  double next_step() const final { return step_to_try(in_use()); }
  void lengthen_next_step(double step) final;
  Counts count() final;
  static int project(sunrealtype t, N_Vector y, void* self);

  struct Stepper {
    void* memory = nullptr;
    bool stopped = false;              // the last step ended at the stop time
    bool used = false;                 // it has made steps, so the growth limit of the first step no longer applies
    std::optional<double> first_step;  // s: first step to be tried; 0: it chooses one
    double last_step = 0;              // s: the step before that; 0: not relevant
    double growth = 1;                 // limit on the ratio of the next step to the last one
  };
  double step_to_try(std::size_t i) const;  // s
  static void try_first(Stepper& stepper, double step);
  static void limit_first_growth(const Stepper& stepper);
  std::size_t in_use() const { return std::ranges::find(steppers_, memory_, &Stepper::memory) - steppers_.begin(); }

  std::vector<Stepper> steppers_;
  bool touched_ = false;  // see inputs_touched()
  // The derivative evaluated last, in memory of ARKODE: the one with which the next step starts, if keeps_derivative().
  const double* derivative_ = nullptr;
  std::vector<double> kept_derivative_;  // of a saved state
};

}  // namespace gelenk
