// SPDX-License-Identifier: BSD-3-Clause
#include "integrator/step_controller.h"

#include <algorithm>
#include <cmath>

#include "integrator/sundials.h"

namespace gelenk::sundials {
namespace {

constexpr double bias = 1.5;          // on error estimates, ARKODE's own
constexpr double least_error = 1e-6;  // below it an estimate may be rounding
constexpr double least_growth = 0.1;  // of a step over the one before, ARKODE's own

struct Before {
  double step = 0, error = 0;  // s; of the last accepted step, none: 0
  double tried = 0, next = 0;  // s: the last step tried, and the one thought best after it
};

Before& before(SUNAdaptController c) { return *static_cast<Before*>(c->content); }

SUNAdaptController_Type type(SUNAdaptController) { return SUN_ADAPTCONTROLLER_H; }

// From one step to the next the error's factor of h^k changes, and as much again from this one to the next: where the
// steps were cut short at communication points this holds, too.
SUNErrCode estimate(SUNAdaptController c, sunrealtype h, int p, sunrealtype error, sunrealtype* next) {
  const double k = p + 1;
  const double e = std::max(bias * error, 1e-10);
  *next = h * std::pow(e, -1 / k);
  const Before& last = before(c);
  if (last.error > least_error && e > least_error) {
    *next *= std::min(1.0, h / last.step * std::pow(last.error / e, 1 / k));
  }
  before(c).tried = h;
  before(c).next = *next;
  return SUN_SUCCESS;
}

SUNErrCode accept(SUNAdaptController c, sunrealtype h, sunrealtype error) {
  before(c).step = h;
  before(c).error = bias * error;
  return SUN_SUCCESS;
}

// Asked for when a stepper is taken to where a run was saved, of which all that is remembered is still true.
SUNErrCode reset(SUNAdaptController) { return SUN_SUCCESS; }

SUNErrCode destroy(SUNAdaptController c) {
  delete &before(c);
  SUNAdaptController_DestroyEmpty(c);
  return SUN_SUCCESS;
}

}  // namespace

StepController make_step_controller(SUNContext context) {
  auto content = std::make_unique<Before>();
  StepController controller(made(SUNAdaptController_NewEmpty(context)));
  controller->content = content.release();
  controller->ops->gettype = type;
  controller->ops->estimatestep = estimate;
  controller->ops->updateh = accept;
  controller->ops->reset = reset;
  controller->ops->destroy = destroy;
  return controller;
}

// As ARKODE does it, to the rounding.
double next_step(const StepController& controller, double safety, double most_growth) {
  const auto [step, error, tried, next] = before(controller.get());
  if (tried == 0) return 0;
  return tried * (std::max(std::min(next * safety, most_growth * tried), least_growth * tried) / tried);
}

void serialize(const StepController& controller, Archive& archive) {
  Before& last = before(controller.get());
  archive.serialize(last.step, last.error, last.tried, last.next);
}

}  // namespace gelenk::sundials
