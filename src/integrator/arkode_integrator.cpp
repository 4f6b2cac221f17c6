// SPDX-License-Identifier: BSD-3-Clause
#include "integrator/arkode_integrator.h"

#include <algorithm>

namespace gelenk {

ArkodeIntegrator::~ArkodeIntegrator() {
  for (void*& stepper : steppers_) ARKodeFree(&stepper);
}

void ArkodeIntegrator::own(void* memory, double tolerance) {
  memory_ = sundials::made(memory);
  steppers_.push_back(memory_);
  ARKodeSetUserData(memory_, user_data());
  ARKodeSStolerances(memory_, tolerance, tolerance);
  ARKodeSetPostprocessStepFn(memory_, project);
  ARKodeSetMaxNumSteps(memory_, -1);
  ARKodeSetMaxErrTestFails(memory_, most_error_fails);
  // No dense output is read: steps end at the communication points.
  ARKodeSetInterpolantType(memory_, ARK_INTERP_NONE);
}

void ArkodeIntegrator::use(int stepper, double step) {
  if (memory_ == steppers_[stepper]) return;
  memory_ = steppers_[stepper];
  ARKodeSetInitStep(memory_, step);
  fresh_ = true;
}

long ArkodeIntegrator::attempts() const {
  long attempts = 0;
  ARKodeGetNumStepAttempts(memory_, &attempts);
  return attempts;
}

double ArkodeIntegrator::next_step() const {
  double step = 0;
  ARKodeGetCurrentStep(memory_, &step);
  return step;
}

void ArkodeIntegrator::prepare(double end) {
  choose_stepper(end);
  begin(end);
}

void ArkodeIntegrator::begin(double end) {
  // A reset drops the derivative kept from the last step, which belongs to the former inputs, but not the step size.
  if (fresh_ || jumped_) ARKodeReset(memory_, t_, y_.get());
  fresh_ = false;
  ARKodeSetStopTime(memory_, end);
}

ArkodeIntegrator::Step ArkodeIntegrator::make_step(double end) {
  const void* before = memory_;
  reconsider_stepper();
  if (memory_ != before) begin(end);
  const int flag = ARKodeEvolve(memory_, end, y_.get(), &t_, ARK_ONE_STEP);
  if (flag >= 0) return Step::made;
  if (flag == ARK_ERR_FAILURE || flag == ARK_CONV_FAILURE) return Step::too_small;
  if (flag == ARK_RHSFUNC_FAIL || flag == ARK_UNREC_RHSFUNC_ERR || flag == ARK_REPTD_RHSFUNC_ERR ||
      flag == ARK_FIRST_RHSFUNC_ERR) {
    return Step::not_finite;
  }
  return flag == ARK_POSTPROCESS_STEP_FAIL ? Step::not_closed : Step::stopped;
}

double ArkodeIntegrator::reached() const {
  double t = t_;
  ARKodeGetCurrentTime(memory_, &t);
  return t;
}

void ArkodeIntegrator::count() {
  steps_ = 0;
  rejected_ = 0;
  for (void* stepper : steppers_) {
    long steps = 0;
    long attempts = 0;
    long failures = 0;
    ARKodeGetNumSteps(stepper, &steps);
    ARKodeGetNumStepAttempts(stepper, &attempts);
    ARKodeGetNumErrTestFails(stepper, &failures);
    steps_ += steps;
    rejected_ += std::max(failures, attempts - steps);
  }
}

int ArkodeIntegrator::project(sunrealtype t, N_Vector y, void* self) {
  return static_cast<SundialsIntegrator*>(self)->system().project(t, sundials::data(y)) ? 0 : 1;
}

}  // namespace gelenk
