// SPDX-License-Identifier: BSD-3-Clause
// SUNDIALS' CVODES for ydot = f(t, y), of variable order and step (Hindmarsh et al. 2005): BDF with Newton's method,
// projected within each step as with IDA, and Adams-Moulton with fixed-point iteration, projected after each step.
#include <cvodes/cvodes.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#include <sunnonlinsol/sunnonlinsol_newton.h>

#include <algorithm>

#include "integrator/sundials_integrator.h"

namespace gelenk {
namespace {

// Fraction of the tolerance used in the local error test, for BDF at a tolerance of 1e-4 (bdf_tolerance, see ida.cpp).
// On the same scenes errors are 0.3 to 60 times the tolerance.
constexpr double bdf_fraction = 0.002;
constexpr double adams_fraction = 0.003;
// Below this the error test is dominated by rounding: with half of it the squeezer takes seventy times as many steps,
// whose errors add up.
constexpr double cvode_min_tolerance = 2e-13;

class Cvode : public SundialsIntegrator {
 public:
  ~Cvode() override { CVodeFree(&memory_); }

 protected:
  // tolerance: of one step.
  Cvode(Equations& system, int method, double tolerance, const EventSource::SlowSliding& slow_sliding)
      : SundialsIntegrator(system, slow_sliding) {
    memory_ = sundials::made(CVodeCreate(method, context_));
    CVodeInit(memory_, sundials::rhs, 0, y_.get());
    CVodeSetUserData(memory_, static_cast<SundialsIntegrator*>(this));
    tolerance = std::max(cvode_min_tolerance, tolerance);
    CVodeSStolerances(memory_, tolerance, tolerance);
    CVodeSetMaxNumSteps(memory_, -1);
    CVodeSetMaxErrTestFails(memory_, max_error_test_failures);
  }

  virtual bool restarts_at_jumps() const = 0;
  // Completes y_ after a step. Returns false if the projection fails.
  virtual bool finish(double) { return true; }

  void* memory_ = nullptr;
  bool has_jacobian_ = false;  // since the last restart

 private:
  void prepare(double end) final {
    if (fresh_ || (jumped_ && restarts_at_jumps())) {
      keep_counts();
      CVodeReInit(memory_, t_, y_.get());
      has_jacobian_ = false;
      fresh_ = false;
    }
    CVodeSetStopTime(memory_, end);
  }

  Step make_step(double end) final {
    const int flag = CVode(memory_, end, y_.get(), &t_, CV_ONE_STEP);
    if (flag >= 0) return finish(t_) ? Step::made : Step::not_closed;
    if (flag == CV_ERR_FAILURE || flag == CV_CONV_FAILURE) return Step::too_small;
    if (flag == CV_RHSFUNC_FAIL || flag == CV_FIRST_RHSFUNC_ERR || flag == CV_REPTD_RHSFUNC_ERR ||
        flag == CV_UNREC_RHSFUNC_ERR) {
      return Step::not_finite;
    }
    return flag == CV_PROJFUNC_FAIL || flag == CV_REPTD_PROJFUNC_ERR ? Step::not_closed : Step::stopped;
  }

  void set_stop_time(double end) final { CVodeSetStopTime(memory_, end); }

  double reached() const final {
    double t = t_;
    CVodeGetCurrentTime(memory_, &t);
    return t;
  }

  Counts count() final {
    long steps = 0;
    long error_fails = 0;
    long solver_fails = 0;
    CVodeGetNumSteps(memory_, &steps);
    CVodeGetNumErrTestFails(memory_, &error_fails);
    CVodeGetNumNonlinSolvConvFails(memory_, &solver_fails);
    return {steps, error_fails + solver_fails};
  }
};

class Bdf final : public Cvode {
 public:
  Bdf(Equations& system, const IntegratorOptions& options)
      : Cvode(system, CV_BDF, bdf_tolerance(bdf_fraction, options.tolerance),
              gelenk::slow_sliding(options.tolerance, false)),
        linear_(y_.get(), context_),
        projected_(sundials::new_vector(system, context_)) {
    CVodeSetLinearSolver(memory_, linear_.solver.get(), linear_.matrix.get());
    CVodeSetJacFn(memory_, jacobian);
    newton_ = sundials::NonlinearSolver(sundials::made(SUNNonlinSol_Newton(y_.get(), context_)));
    newton_solve_ = newton_->ops->solve;
    newton_->ops->solve = solve_and_project;
    CVodeSetNonlinearSolver(memory_, newton_.get());
  }

 private:
  // If the starter does not handle them (starter.cpp), the scene is stiff, and the history is worth keeping.
  bool restarts_at_jumps() const override { return false; }
  double finest_tolerance() const override { return inverse_bdf_tolerance(bdf_fraction, cvode_min_tolerance); }

  // CVODE reuses a Jacobian for up to 51 steps. If it is too stiff in one direction, corrections there are too small,
  // but look as if Newton's method converged.
  void before_step() override {
    const long frequency = has_jacobian_ && system_.jacobian_is_outdated() ? 1 : 0;  // 0: the default
    CVodeSetJacEvalFrequency(memory_, frequency);
    CVodeSetLSetupFrequency(memory_, frequency);
  }

  static int jacobian(sunrealtype t, N_Vector y, N_Vector ydot, SUNMatrix J, void* self, N_Vector a, N_Vector b,
                      N_Vector c) {
    static_cast<Bdf&>(*static_cast<SundialsIntegrator*>(self)).has_jacobian_ = true;
    return sundials::jacobian(t, y, ydot, J, self, a, b, c);
  }

  // As with IDA (ida.cpp), the difference of the projected state from the prediction is returned as the correction of
  // the step. CVODE's own projection function changes the state only, not the derivatives of the history.
  static int solve_and_project(SUNNonlinearSolver solver, N_Vector y0, N_Vector correction, N_Vector weights,
                               sunrealtype tolerance, sunbooleantype setup, void* memory) {
    double t = 0;
    double other = 0;
    N_Vector predicted = nullptr;
    N_Vector vector = nullptr;
    void* self = nullptr;
    CVodeGetNonlinearSystemData(memory, &t, &predicted, &vector, &vector, &other, &other, &vector, &self);
    Bdf& bdf = static_cast<Bdf&>(*static_cast<SundialsIntegrator*>(self));
    const int flag = bdf.newton_solve_(solver, y0, correction, weights, tolerance, setup, memory);
    if (flag != SUN_SUCCESS) return flag;
    N_Vector y = bdf.projected_.get();
    N_VLinearSum(1, predicted, 1, correction, y);
    if (!bdf.system_.project(t, sundials::data(y))) return SUN_NLS_CONV_RECVR;
    N_VLinearSum(1, y, -1, predicted, correction);
    return flag;
  }

  sundials::DenseSolver linear_;
  sundials::Vector projected_;
  sundials::NonlinearSolver newton_;
  sundials::NewtonSolve newton_solve_ = nullptr;
};

// An Adams method extrapolates derivatives: a projection returned as part of the correction, as with BDF, would enter
// them divided by the step and spoil the next error estimate (four-bar: the step decreases to zero). Therefore only the
// state from which the next step starts is projected, after the step; the derivatives are unchanged.
class Adams final : public Cvode {
 public:
  Adams(Equations& system, const IntegratorOptions& options)
      : Cvode(system, CV_ADAMS, adams_fraction * options.tolerance, gelenk::slow_sliding(options.tolerance, true)),
        solver_(sundials::made(SUNNonlinSol_FixedPoint(y_.get(), 0, context_))) {
    CVodeSetNonlinearSolver(memory_, solver_.get());
  }

 private:
  // Derivatives continued across a jump spoil many steps: on the four-bar with a new torque every millisecond and no
  // starter, tolerance 1e-8, errors are 1e4 times the tolerance instead of some hundred times, for as much work.
  bool restarts_at_jumps() const override { return true; }
  double finest_tolerance() const override { return cvode_min_tolerance / adams_fraction; }

  bool finish(double t) override {
    if (!system_.project(t, sundials::data(y_.get()))) return false;
    // Between steps, the vector that becomes the next prediction holds the state reached.
    N_Vector state = nullptr;
    N_Vector other = nullptr;
    double time = 0;
    double factor = 0;
    void* self = nullptr;
    CVodeGetNonlinearSystemData(memory_, &time, &state, &other, &other, &factor, &factor, &other, &self);
    N_VScale(1, y_.get(), state);
    return true;
  }

  sundials::NonlinearSolver solver_;
};

}  // namespace

std::unique_ptr<Integrator> make_cvode(Equations& system, const IntegratorOptions& options) {
  return std::make_unique<Bdf>(system, options);
}

std::unique_ptr<Integrator> make_cvode_adams(Equations& system, const IntegratorOptions& options) {
  return std::make_unique<Adams>(system, options);
}

}  // namespace gelenk
