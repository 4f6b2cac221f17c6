// SPDX-License-Identifier: BSD-3-Clause
// The way from one communication point to the next, which SUNDIALS' adaptive integrators share.
#pragma once

#include <memory>
#include <vector>

#include "event/locator.h"
#include "integrator/integrator.h"
#include "integrator/sundials.h"

namespace gelenk {

// For the error of one step of BDF: this share of the tolerance at 1e-4, and less below. Steps of order 5 become
// shorter as its sixth root and more in number, and what they leave adds up: a fixed share of it would leave errors as
// tolerance^(5/6), at 1e-8 six times as many tolerances as at 1e-4.
double bdf_tolerance(double share, double tolerance);
// The tolerance of which that is the error of one step.
double tolerance_of_bdf(double share, double error);

class SundialsIntegrator : public Integrator, private Stepping {
 public:
  void restart(double t, const double* y) final;
  void inputs_changed() final { jumped_ = true; }
  void pass_events(bool on) final { passes_events_ = on; }
  double advance(double end, double* y) final;
  double advance_some(double end, double* y, long most) final;
  bool will_have_history() const override { return true; }
  bool has_history() const override { return !fresh_; }
  void serialize(Archive& archive) override;

  Equations& system() const { return system_; }

 protected:
  // takes_differences: of the states it has been through.
  explicit SundialsIntegrator(Equations& system, bool takes_differences = true);

  // Before the steps to `end`: begins anew at (t_, y_) if fresh_, and stops at `end`.
  virtual void prepare(double end) = 0;
  // One step; writes t_ and y_.
  virtual Step make_step(double end) = 0;
  // How far the step that failed had come [s].
  virtual double reached() const = 0;
  // Takes up (t_, y_) if fresh_; steps stop at `end` from now on.
  virtual void begin(double end) { prepare(end); }
  // Steps made and refused: all, or since keep_counts() by methods that forget them when they begin anew.
  struct Counts {
    long steps = 0, rejected = 0;
  };
  virtual Counts count() = 0;
  void keep_counts();

  // A step that meets a jump of the forces (a damped stop) shrinks until it is as short as the jump is small.
  static constexpr int most_error_fails = 40;

  sundials::Context context_;
  Equations& system_;
  sundials::Vector y_;  // of a DAE the multipliers are behind y in it
  double t_ = 0;
  bool fresh_ = true;    // (t_, y_) is not where the last step ended
  bool jumped_ = false;  // the inputs are not those of the last step

 private:
  double time() const final { return t_; }
  const double* state() const final { return sundials::data(y_.get()); }
  Step step_towards(double end) final { return make_step(end); }
  void go_to(double t, const double* y) final { restart(t, y); }
  void stop_at(double end) final { begin(end); }
  [[noreturn]] void fail(Step step, double start);

  Locator locator_;
  bool takes_differences_;
  bool passes_events_ = false;
  StallDetector stall_detector_{0, 0};
  double patience_end_ = 0;  // s: of the advance that it is for
  Counts kept_;
};

namespace sundials {

// f(t, y) and exact df/dy, as ARKODE and CVODES call for them. integrator: a SundialsIntegrator*.
int rhs(sunrealtype t, N_Vector y, N_Vector ydot, void* integrator);
int jacobian(sunrealtype t, N_Vector y, N_Vector ydot, SUNMatrix J, void* integrator, N_Vector, N_Vector, N_Vector);
// unknowns() zeros.
N_Vector new_vector(const Equations& system, SUNContext context);

}  // namespace sundials

}  // namespace gelenk
