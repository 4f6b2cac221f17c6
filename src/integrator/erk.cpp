// SPDX-License-Identifier: BSD-3-Clause
// Explicit Runge-Kutta with adaptive steps (ARKODE's ERKStep), projected after each accepted step.
#include <arkode/arkode.h>
#include <arkode/arkode_erkstep.h>

#include <algorithm>
#include <cmath>

#include "integrator/integrator.h"
#include "integrator/sundials.h"

namespace gelenk {
namespace {

// Of ARKODE's tables of order 5 to 9 these two gave the smallest error for the evaluations spent, on loops and trees
// (four-bar, slider-crank, Andrews' squeezer, double pendulum, heavy top, cart-pole): order 6 above, 8 below.
ARKODE_ERKTableID table_for(double tolerance) { return tolerance > 3e-7 ? ARKODE_VERNER_9_5_6 : ARKODE_VERNER_13_7_8; }

// With ARKODE's own 0.96 every third step was rejected on the same scenes. Controllers with a memory (PI, Gustafsson)
// do better still over long stretches, but lose it all where steps end at communication points: those steps are cut
// short, and their tiny errors mislead the next.
constexpr double safety = 0.8;

class Erk final : public Integrator {
 public:
  Erk(OdeSystem& system, const IntegratorOptions& options)
      : system_(system), n_(system.size()), y_(sundials::made(N_VNew_Serial(std::max(1, n_), context_))) {
    N_VConst(0, y_.get());
    memory_ = sundials::made(ERKStepCreate(rhs, 0, y_.get(), context_));
    ARKodeSetUserData(memory_, this);
    ARKodeSStolerances(memory_, options.tolerance, options.tolerance);
    ERKStepSetTableNum(memory_, table_for(options.tolerance));
    ARKodeSetSafetyFactor(memory_, safety);
    ARKodeSetPostprocessStepFn(memory_, project);
    ARKodeSetMaxNumSteps(memory_, -1);
    // No dense output is read: steps end at the communication points.
    ARKodeSetInterpolantType(memory_, ARK_INTERP_NONE);
  }
  ~Erk() override { ARKodeFree(&memory_); }

  void restart(double t, const double* y) override {
    t_ = t;
    std::copy(y, y + n_, sundials::data(y_.get()));
    fresh_ = true;
  }
  void inputs_changed() override { fresh_ = true; }

  void advance(double end, double* y) override {
    // A reset drops the derivative kept from the last step, which belongs to the former inputs, but not the step size.
    if (fresh_) ARKodeReset(memory_, t_, y_.get());
    fresh_ = false;
    ARKodeSetStopTime(memory_, end);
    const double start = t_;
    Patience patience(start, end);
    while (t_ < end) {
      const int flag = ARKodeEvolve(memory_, end, y_.get(), &t_, ARK_ONE_STEP);
      if (flag < 0) fail(flag, start);
      system_.accepted(t_, sundials::data(y_.get()));
      patience.step_to(t_);
    }
    count();
    std::copy(sundials::data(y_.get()), sundials::data(y_.get()) + n_, y);
  }

 private:
  static int rhs(sunrealtype t, N_Vector y, N_Vector ydot, void* self) {
    return static_cast<Erk*>(self)->system_.rhs(t, sundials::data(y), sundials::data(ydot)) ? 0 : 1;
  }
  static int project(sunrealtype t, N_Vector y, void* self) {
    return static_cast<Erk*>(self)->system_.project(t, sundials::data(y)) ? 0 : 1;
  }

  void count() {
    long attempts = 0;
    long failures = 0;
    ARKodeGetNumSteps(memory_, &steps_);
    ARKodeGetNumStepAttempts(memory_, &attempts);
    ARKodeGetNumErrTestFails(memory_, &failures);
    rejected_ = std::max(failures, attempts - steps_);
  }

  [[noreturn]] void fail(int flag, double start) const {
    double reached = start;
    ARKodeGetCurrentTime(memory_, &reached);
    if (!std::isfinite(reached)) reached = start;
    if (flag == ARK_ERR_FAILURE || flag == ARK_CONV_FAILURE) {
      throw IntegrationError(at_time(reached) + "no step is small enough for the tolerance");
    }
    if (flag == ARK_RHSFUNC_FAIL || flag == ARK_UNREC_RHSFUNC_ERR || flag == ARK_REPTD_RHSFUNC_ERR ||
        flag == ARK_FIRST_RHSFUNC_ERR) {
      throw IntegrationError(at_time(reached) + "the accelerations are not finite");
    }
    if (flag == ARK_POSTPROCESS_STEP_FAIL) {
      throw IntegrationError(at_time(reached) + "the loops could not be closed again");
    }
    throw IntegrationError(at_time(reached) + "the integrator stopped (" + context_.last_error() + ")");
  }

  sundials::Context context_;
  OdeSystem& system_;
  int n_;
  sundials::Vector y_;
  void* memory_ = nullptr;
  double t_ = 0;
  bool fresh_ = true;
};

}  // namespace

std::unique_ptr<Integrator> make_erk(OdeSystem& system, const IntegratorOptions& options) {
  return std::make_unique<Erk>(system, options);
}

}  // namespace gelenk
