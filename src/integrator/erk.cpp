// SPDX-License-Identifier: BSD-3-Clause
// Explicit Runge-Kutta with adaptive steps (ARKODE's ERKStep), projected after each accepted step.
#include <arkode/arkode.h>
#include <arkode/arkode_erkstep.h>

#include <algorithm>

#include "integrator/sundials_integrator.h"

namespace gelenk {
namespace {

// Of ARKODE's tables of order 5 to 9 these two gave the smallest error for the evaluations spent, on loops and trees
// (four-bar, slider-crank, Andrews' squeezer, double pendulum, heavy top, cart-pole): order 6 above, 8 below.
ARKODE_ERKTableID table_for(double tolerance) { return tolerance > 3e-7 ? ARKODE_VERNER_9_5_6 : ARKODE_VERNER_13_7_8; }

// With ARKODE's own 0.96 every third step was rejected on the same scenes. Controllers with a memory (PI, Gustafsson)
// do better still over long stretches, but lose it all where steps end at communication points: those steps are cut
// short, and their tiny errors mislead the next.
constexpr double safety = 0.8;

class Erk final : public SundialsIntegrator {
 public:
  Erk(OdeSystem& system, const IntegratorOptions& options) : SundialsIntegrator(system) {
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

 private:
  void prepare(double end) override {
    // A reset drops the derivative kept from the last step, which belongs to the former inputs, but not the step size.
    if (fresh_ || jumped_) ARKodeReset(memory_, t_, y_.get());
    fresh_ = false;
    ARKodeSetStopTime(memory_, end);
  }

  Step make_step(double end) override {
    const int flag = ARKodeEvolve(memory_, end, y_.get(), &t_, ARK_ONE_STEP);
    if (flag >= 0) return Step::made;
    if (flag == ARK_ERR_FAILURE || flag == ARK_CONV_FAILURE) return Step::too_small;
    if (flag == ARK_RHSFUNC_FAIL || flag == ARK_UNREC_RHSFUNC_ERR || flag == ARK_REPTD_RHSFUNC_ERR ||
        flag == ARK_FIRST_RHSFUNC_ERR) {
      return Step::not_finite;
    }
    return flag == ARK_POSTPROCESS_STEP_FAIL ? Step::not_closed : Step::stopped;
  }

  double reached() const override {
    double t = t_;
    ARKodeGetCurrentTime(memory_, &t);
    return t;
  }

  void count() override {
    long attempts = 0;
    long failures = 0;
    ARKodeGetNumSteps(memory_, &steps_);
    ARKodeGetNumStepAttempts(memory_, &attempts);
    ARKodeGetNumErrTestFails(memory_, &failures);
    rejected_ = std::max(failures, attempts - steps_);
  }

  static int rhs(sunrealtype t, N_Vector y, N_Vector ydot, void* self) {
    return static_cast<Erk*>(self)->system_.rhs(t, sundials::data(y), sundials::data(ydot)) ? 0 : 1;
  }
  static int project(sunrealtype t, N_Vector y, void* self) {
    return static_cast<Erk*>(self)->system_.project(t, sundials::data(y)) ? 0 : 1;
  }

  void* memory_ = nullptr;
};

}  // namespace

std::unique_ptr<Integrator> make_erk(OdeSystem& system, const IntegratorOptions& options) {
  return std::make_unique<Erk>(system, options);
}

}  // namespace gelenk
