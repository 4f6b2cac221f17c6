// SPDX-License-Identifier: BSD-3-Clause
// Base class of the adaptive SUNDIALS integrators: steps from one communication point to the next.
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "event/locator.h"
#include "integrator/integrator.h"
#include "integrator/sundials.h"

namespace gelenk {

// Tolerance for the local error of a BDF step: this fraction of the tolerance at 1e-4, and less below. Steps of order 5
// decrease with its sixth root, and their errors add up: a constant fraction would leave errors proportional to
// tolerance^(5/6), at 1e-8 six times as many tolerances as at 1e-4.
double bdf_tolerance(double fraction, double tolerance);
// The inverse: the tolerance for which a BDF step has this local error.
double inverse_bdf_tolerance(double fraction, double error);

// Of a method that controls errors with this tolerance.
EventSource::SlowSliding slow_sliding(double tolerance, bool is_explicit);

class SundialsIntegrator : public Integrator, private Stepping {
 public:
  void restart(double t, const double* y) final {
    before_restart();
    continue_from(t, y);
  }
  void begin() final { stalls_.reset(); }
  void inputs_changed() final { jumped_ = true; }
  void pass_events(bool on) final { passes_events_ = on; }
  double advance(double end, double* y) final;
  double advance_some(double end, double* y, long max_steps) final;
  bool will_have_history() const override { return true; }
  bool is_one_step() const final { return !will_have_history(); }
  bool has_history() const override { return !fresh_; }
  void serialize(Archive& archive) override;

  Equations& system() const { return system_; }

 protected:
  // takes_differences: whether the method uses differences of former states.
  SundialsIntegrator(Equations& system, const EventSource::SlowSliding& slow_sliding, bool takes_differences = true);

  // Called before the steps to `end`: restarts at (t_, y_) if fresh_, and sets the stop time.
  virtual void prepare(double end) = 0;
  // Makes one step; writes t_ and y_.
  virtual Step make_step(double end) = 0;
  // Time reached by the step that failed [s].
  virtual double reached() const = 0;
  // Accepted and rejected steps: all, or since keep_counts() for methods that reset them on restart.
  struct Counts {
    long steps = 0, rejected = 0;
  };
  virtual Counts count() = 0;
  void keep_counts();

  // At a discontinuity of the forces (a damped stop) a step is shortened until its length is as small as the
  // discontinuity.
  static constexpr int max_error_test_failures = 40;

  sundials::Context context_;
  Equations& system_;
  sundials::Vector y_;  // for a DAE, followed by the multipliers
  double t_ = 0;
  bool fresh_ = true;    // (t_, y_) is not the end of the last step
  bool jumped_ = false;  // inputs have changed since the last step
  // fresh_ because a saved state was restored, whose run knew the derivative at (t_, y_).
  bool resumed_ = false;

 private:
  // Called where steps begin again at another state, but not after an event.
  virtual void before_restart() {}
  // Also after an event: without the history, but with what is known of the length of steps.
  void continue_from(double t, const double* y);
  // Brings steps_ and rejected_ up to date, unless a restart has ended the counting.
  void add_counts();
  // Continues from (t_, y_) if fresh_, with the stop time `end`.
  virtual void begin(double end) { prepare(end); }
  // Called at the start of each step, and of each repetition; what it sets must not depend on what was before a
  // restart.
  virtual void before_step() {}
  // Steps do not pass this time [s].
  virtual void set_stop_time(double end) = 0;
  double time() const final { return t_; }
  const double* state() const final { return sundials::data(y_.get()); }
  Step step_towards(double end) final {
    before_step();
    return make_limited_step(end);
  }
  // One step that ends where the equations ask for it, if not at `end`.
  Step make_limited_step(double end);
  void go_to(double t, const double* y) final {
    add_counts();
    continue_from(t, y);
  }
  void stop_at(double end) final { begin(stop_time_ = end); }
  EventSource::SlowSliding slow_sliding() const final { return slow_sliding_; }
  [[noreturn]] void fail(Step step, double start);

  Locator locator_;
  EventSource::SlowSliding slow_sliding_;
  bool takes_differences_;
  bool passes_events_ = false;
  std::optional<StallDetector> stalls_;  // of the communication step
  // Why the steps cannot be continued from t_, where they have come since the start of a call: the next call fails.
  Step failed_ = Step::made;
  std::string stall_;
  Counts base_counts_;
  double stop_time_ = INFINITY;  // s
};

namespace sundials {

// f(t, y) and exact df/dy with the signatures of ARKODE and CVODES. integrator: a SundialsIntegrator*.
int rhs(sunrealtype t, N_Vector y, N_Vector ydot, void* integrator);
int jacobian(sunrealtype t, N_Vector y, N_Vector ydot, SUNMatrix J, void* integrator, N_Vector, N_Vector, N_Vector);
// A vector of unknowns() zeros.
N_Vector new_vector(const Equations& system, SUNContext context);

}  // namespace sundials

}  // namespace gelenk
