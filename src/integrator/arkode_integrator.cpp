// SPDX-License-Identifier: BSD-3-Clause
#include "integrator/arkode_integrator.h"

#include <algorithm>
#include <array>

namespace gelenk {
namespace {

// Limits on the ratio of a step to the one before, as in ARKODE. After a step with several attempts the next one is not
// longer.
constexpr double max_growth = 20;
constexpr double max_first_growth = 1e4;

// The step [s] that follows `last` if `next` would be best, cut short at `end`, computed to the last bit as ARKODE does
// in an uninterrupted run; a stepper restored from a saved state does not know it.
double step_to_end(double next, double last, double t, double end) {
  if (t + next <= end) return next;
  const double left = (end - t) * (1 - 4 * SUN_UNIT_ROUNDOFF);
  return last * (left / last);
}

// out = sum of c[j] x[j] in one pass, since the vectors are short. out may be one of them.
template <int count>
void combine(const double* c, N_Vector* x, N_Vector out) {
  const double* from[count];
  for (int j = 0; j < count; ++j) from[j] = NV_DATA_S(x[j]);
  double* to = NV_DATA_S(out);
  const sunindextype n = NV_LENGTH_S(out);
  for (sunindextype i = 0; i < n; ++i) {
    double sum = c[0] * from[0][i];
    for (int j = 1; j < count; ++j) sum += c[j] * from[j][i];
    to[i] = sum;
  }
}

SUNErrCode combine_any(int count, sunrealtype* c, N_Vector* x, N_Vector out) {
  switch (count) {
    case 2:
      return combine<2>(c, x, out), SUN_SUCCESS;
    case 3:
      return combine<3>(c, x, out), SUN_SUCCESS;
    case 4:
      return combine<4>(c, x, out), SUN_SUCCESS;
    case 5:
      return combine<5>(c, x, out), SUN_SUCCESS;
    case 6:
      return combine<6>(c, x, out), SUN_SUCCESS;
    case 7:
      return combine<7>(c, x, out), SUN_SUCCESS;
    default:
      return N_VLinearCombination_Serial(count, c, x, out);
  }
}

}  // namespace

ArkodeIntegrator::ArkodeIntegrator(Equations& system, const EventSource::SlowSliding& slow_sliding)
    : SundialsIntegrator(system, slow_sliding, false), kept_derivative_(static_cast<std::size_t>(system.size())) {
  y_->ops->nvlinearcombination = combine_any;  // all vectors of the steppers are clones of y_
}

ArkodeIntegrator::~ArkodeIntegrator() {
  for (Stepper& stepper : steppers_) ARKodeFree(&stepper.memory);
}

void ArkodeIntegrator::adopt(void* memory, double tolerance) {
  memory_ = sundials::made(memory);
  steppers_.emplace_back().memory = memory_;
  ARKodeSetUserData(memory_, static_cast<SundialsIntegrator*>(this));
  ARKodeSStolerances(memory_, tolerance, tolerance);
  ARKodeSetPostprocessStepFn(memory_, project);
  ARKodeSetMaxNumSteps(memory_, -1);
  ARKodeSetMaxGrowth(memory_, max_growth);
  ARKodeSetMaxErrTestFails(memory_, max_error_test_failures);
  // Dense output is not used: steps end at the communication points.
  ARKodeSetInterpolantType(memory_, ARK_INTERP_NONE);
}

void ArkodeIntegrator::use(int stepper, double step) {
  Stepper& next = steppers_[stepper];
  if (memory_ == next.memory) return;
  memory_ = next.memory;
  try_first(next, step);
  fresh_ = true;
  resumed_ = false;
}

// The step to try first is given in one way, whether ARKODE knows it or it comes from a saved state: of its own, ARKODE
// would take one that differs by rounding.
void ArkodeIntegrator::before_restart() {
  for (std::size_t i = 0; i < steppers_.size(); ++i) {
    try_first(steppers_[i], step_to_try(i));
    limit_first_growth(steppers_[i]);
  }
}

int ArkodeIntegrator::rhs(sunrealtype t, N_Vector y, N_Vector ydot, void* self) {
  auto& at = static_cast<ArkodeIntegrator&>(*static_cast<SundialsIntegrator*>(self));
  double* const out = sundials::data(ydot);
  at.derivative_ = out;
  if (!at.resumed_) return at.system_.rhs(t, sundials::data(y), out) ? 0 : 1;
  at.resumed_ = false;
  std::ranges::copy(at.kept_derivative_, out);
  return 0;
}

long ArkodeIntegrator::attempts() const {
  long attempts = 0;
  ARKodeGetNumStepAttempts(memory_, &attempts);
  return attempts;
}

double ArkodeIntegrator::current_step() const { return current_step(memory_); }

double ArkodeIntegrator::step_after_stop(std::size_t stepper) const { return current_step(steppers_[stepper].memory); }

double ArkodeIntegrator::step_to_try(std::size_t i) const {
  const Stepper& stepper = steppers_[i];
  if (stepper.first_step) return *stepper.first_step;
  return stepper.stopped ? step_after_stop(i) : current_step(stepper.memory);
}

void ArkodeIntegrator::lengthen_next_step(double step) {
  if (step > next_step()) try_first(steppers_[in_use()], step);
}

void ArkodeIntegrator::try_first(Stepper& stepper, double step) {
  stepper.first_step = step;
  stepper.last_step = 0;
  ARKodeSetInitStep(stepper.memory, step);
}

void ArkodeIntegrator::limit_first_growth(const Stepper& stepper) {
  ARKodeSetMaxFirstGrowth(stepper.memory, stepper.used ? max_growth : max_first_growth);
}

double ArkodeIntegrator::current_step(void* memory) {
  double step = 0;
  ARKodeGetCurrentStep(memory, &step);
  return step;
}

// ARKODE cannot copy its memory, but of a one-step method only the length of the next step matters.
void ArkodeIntegrator::serialize(Archive& archive) {
  const bool resumed = resumed_;
  bool has_derivative = resumed || (!fresh_ && derivative_ != nullptr && keeps_derivative());
  SundialsIntegrator::serialize(archive);
  archive.serialize(step_at_end_, has_derivative);
  if (has_derivative) {
    if (!archive.reading() && !resumed) std::copy_n(derivative_, kept_derivative_.size(), kept_derivative_.begin());
    archive.serialize(kept_derivative_);
  }
  if (archive.reading()) {
    resumed_ = has_derivative;
    touched_ = false;
  }
  for (std::size_t i = 0; i < steppers_.size(); ++i) {
    Stepper& stepper = steppers_[i];
    std::array<double, 3> numbers{step_to_try(i), stepper.last_step, stepper.used ? 1.0 : 0.0};
    if (!stepper.first_step) ARKodeGetLastStep(stepper.memory, &numbers[1]);
    archive.serialize(numbers);
    if (!archive.reading()) continue;
    stepper.first_step = numbers[0];
    stepper.last_step = numbers[1];
    stepper.used = numbers[2] != 0;
    reinitialize(stepper.memory);
    ARKodeSetInitStep(stepper.memory, numbers[0]);
    limit_first_growth(stepper);
  }
}

void ArkodeIntegrator::prepare(double end) {
  choose_stepper(end);
  begin(end);
}

void ArkodeIntegrator::begin(double end) {
  // A reset discards the derivative from the last step, which belongs to the former inputs, but not the step size.
  if (jumped_ || touched_) resumed_ = false;
  if (fresh_ || jumped_ || touched_) ARKodeReset(memory_, t_, y_.get());
  fresh_ = touched_ = false;
  ARKodeSetStopTime(memory_, end);
  const Stepper& stepper = steppers_[in_use()];
  if (stepper.first_step && stepper.last_step > 0) {
    ARKodeSetInitStep(memory_, step_to_end(*stepper.first_step, stepper.last_step, t_, end));
  }
}

Step ArkodeIntegrator::make_step(double end) {
  const void* before = memory_;
  reconsider_stepper();
  if (memory_ != before) begin(end);
  const long attempts_before = attempts();
  double reached = t_;  // where a stage fails that is not finite, the time of this stage, with the state at the start
  const int flag = ARKodeEvolve(memory_, end, y_.get(), &reached, ARK_ONE_STEP);
  if (flag >= 0) {
    t_ = reached;
    Stepper& stepper = steppers_[in_use()];
    stepper.growth = attempts() - attempts_before > 1 ? 1 : stepper.used ? max_growth : max_first_growth;
    stepper.used = true;
    stepper.stopped = flag == ARK_TSTOP_RETURN;
    stepper.first_step.reset();
    return Step::made;
  }
  if (flag == ARK_ERR_FAILURE || flag == ARK_CONV_FAILURE) return Step::too_small;
  if (flag == ARK_RHSFUNC_FAIL || flag == ARK_UNREC_RHSFUNC_ERR || flag == ARK_REPTD_RHSFUNC_ERR ||
      flag == ARK_FIRST_RHSFUNC_ERR) {
    return Step::not_finite;
  }
  return flag == ARK_POSTPROCESS_STEP_FAIL ? Step::not_closed : Step::stopped;
}

void ArkodeIntegrator::set_stop_time(double end) { ARKodeSetStopTime(memory_, end); }

double ArkodeIntegrator::reached() const {
  double t = t_;
  ARKodeGetCurrentTime(memory_, &t);
  return t;
}

SundialsIntegrator::Counts ArkodeIntegrator::count() {
  Counts all;
  for (const Stepper& stepper : steppers_) {
    long steps = 0;
    long attempts = 0;
    long failures = 0;
    ARKodeGetNumSteps(stepper.memory, &steps);
    ARKodeGetNumStepAttempts(stepper.memory, &attempts);
    ARKodeGetNumErrTestFails(stepper.memory, &failures);
    all.steps += steps;
    all.rejected += std::max(failures, attempts - steps);
  }
  step_at_end_ = current_step();
  return all;
}

int ArkodeIntegrator::project(sunrealtype t, N_Vector y, void* self) {
  return static_cast<SundialsIntegrator*>(self)->system().project(t, sundials::data(y)) ? 0 : 1;
}

}  // namespace gelenk
