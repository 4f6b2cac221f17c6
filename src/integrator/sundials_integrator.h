// SPDX-License-Identifier: BSD-3-Clause
// The way from one communication point to the next, which SUNDIALS' adaptive integrators share.
#pragma once

#include <memory>
#include <vector>

#include "integrator/integrator.h"
#include "integrator/sundials.h"

namespace gelenk {

// For the error of one step of BDF: this share of the tolerance at 1e-4, and less below. Steps of order 5 become
// shorter as its sixth root and more in number, and what they leave adds up: a fixed share of it would leave errors as
// tolerance^(5/6), at 1e-8 six times as many tolerances as at 1e-4.
double bdf_tolerance(double share, double tolerance);
// The tolerance of which that is the error of one step.
double tolerance_of_bdf(double share, double error);

class SundialsIntegrator : public Integrator {
 public:
  void restart(double t, const double* y) final;
  void inputs_changed() final { jumped_ = true; }
  double advance(double end, double* y) final;
  double advance_some(double end, double* y, long most) final;
  bool will_have_past() const override { return true; }
  bool has_past() const override { return !fresh_; }
  void exchange(Record& record) override;

  Equations& system() const { return system_; }

 protected:
  enum class Step { made, too_small, not_finite, not_closed, stopped };

  explicit SundialsIntegrator(Equations& system);
  N_Vector new_vector();  // unknowns() zeros

  // Whether it takes differences of the states it has been through.
  virtual bool takes_differences() const { return true; }
  // Before the steps to `end`: begins anew at (t_, y_) if fresh_, and stops at `end`.
  virtual void prepare(double end) = 0;
  // One step; writes t_ and y_.
  virtual Step make_step(double end) = 0;
  // How far the step that failed had come [s].
  virtual double reached() const = 0;
  // Whether a step can be taken back and made shorter at no loss: then steps end at the zeros of the system's switches.
  virtual bool steps_back() const { return false; }
  // Of such: takes up (t_, y_), from where steps stop at `end` now.
  virtual void begin(double /*end*/) {}
  // Writes steps_ and rejected_.
  virtual void count() = 0;

  // For methods that forget their counts when they begin anew: call keep_counts() then, add_kept_counts() in count().
  void keep_counts();
  void add_kept_counts();

  // A step that meets a jump of the forces (a damped stop) shrinks until it is as short as the jump is small.
  static constexpr int most_error_fails = 40;

  // What SUNDIALS hands back to the functions it calls: a SundialsIntegrator*.
  void* user_data() { return this; }
  // f(t, y) and exact df/dy, as ARKODE and CVODES call for them.
  static int rhs(sunrealtype t, N_Vector y, N_Vector ydot, void* self);
  static int jacobian(sunrealtype t, N_Vector y, N_Vector ydot, SUNMatrix J, void* self, N_Vector, N_Vector, N_Vector);

  sundials::Context context_;
  Equations& system_;
  int n_;  // of y; of a DAE the multipliers are behind it in y_
  sundials::Vector y_;
  double t_ = 0;
  bool fresh_ = true;    // (t_, y_) is not where the last step ended
  bool jumped_ = false;  // the inputs are not those of the last step

 private:
  // Of methods that step back (switch_search.cpp).
  Step step_to_switch(double end);
  Step search(std::size_t i, double end);
  Step step_from_start(double end);
  bool strayed_inside(double end) const;
  void keep_start();
  void keep_high();
  void read_switches(std::vector<double>& g, std::vector<double>& gdot, bool* on) const;
  bool crossed(std::size_t i) const { return on_[i] != start_on_[i]; }
  double estimate(std::size_t i) const;
  [[noreturn]] void fail(Step step, double start);

  // At the start of a step, where the step made ended, and at the earliest end known to be beyond a switch.
  double start_t_ = 0, high_t_ = 0;
  std::vector<double> start_y_, start_g_, start_gdot_, g_, gdot_, high_y_;
  std::unique_ptr<bool[]> start_on_, on_;  // by switch
  Patience patience_{0, 0};
  double patience_end_ = 0;  // s: of the advance that it is for
  long kept_steps_ = 0;
  long kept_rejected_ = 0;
};

}  // namespace gelenk
