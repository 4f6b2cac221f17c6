// SPDX-License-Identifier: BSD-3-Clause
#include "integrator/step_controller.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "integrator/sundials.h"

namespace gelenk::sundials {
namespace {

constexpr double bias = 1.5;        // factor on error estimates, ARKODE's own
constexpr double min_error = 1e-6;  // smaller estimates may be rounding
constexpr double min_growth = 0.1;  // ratio of a step to the one before, ARKODE's own

struct History {
  double step = 0, error = 0;  // s, and error of the last accepted step; 0: none
  double tried = 0, next = 0;  // s: the last step tried, and the best next step according to it
};

History& history(SUNAdaptController c) { return *static_cast<History*>(c->content); }

SUNAdaptController_Type type(SUNAdaptController) { return SUN_ADAPTCONTROLLER_H; }

// The coefficient of h^k in the error has changed from the last step to this one and is assumed to change by the same
// factor again; this also holds for steps cut short at communication points.
SUNErrCode estimate(SUNAdaptController c, sunrealtype h, int p, sunrealtype error, sunrealtype* next) {
  const double k = p + 1;
  const double e = std::max(bias * error, 1e-10);
  *next = h * std::pow(e, -1 / k);
  const History& last = history(c);
  if (last.error > min_error && e > min_error) {
    *next *= std::min(1.0, h / last.step * std::pow(last.error / e, 1 / k));
  }
  history(c).tried = h;
  history(c).next = *next;
  return SUN_SUCCESS;
}

SUNErrCode accept(SUNAdaptController c, sunrealtype h, sunrealtype error) {
  history(c).step = h;
  history(c).error = bias * error;
  return SUN_SUCCESS;
}

// Called when a stepper is restored to a saved state, for which the history is still valid.
SUNErrCode reset(SUNAdaptController) { return SUN_SUCCESS; }

SUNErrCode destroy(SUNAdaptController c) {
  delete &history(c);
  SUNAdaptController_DestroyEmpty(c);
  return SUN_SUCCESS;
}

}  // namespace

StepController make_step_controller(SUNContext context) {
  auto content = std::make_unique<History>();
  StepController controller(made(SUNAdaptController_NewEmpty(context)));
  controller->content = content.release();
  controller->ops->gettype = type;
  controller->ops->estimatestep = estimate;
  controller->ops->updateh = accept;
  controller->ops->reset = reset;
  controller->ops->destroy = destroy;
  return controller;
}

// Computed as by ARKODE, to the last bit.
double next_step(const StepController& controller, double safety, double max_growth) {
  const auto [step, error, tried, next] = history(controller.get());
  if (tried == 0) return 0;
  return tried * (std::max(std::min(next * safety, max_growth * tried), min_growth * tried) / tried);
}

void serialize(const StepController& controller, Archive& archive) {
  History& last = history(controller.get());
  std::array<double, 4> numbers{last.step, last.error, last.tried, last.next};
  archive.serialize(numbers);
  last = {.step = numbers[0], .error = numbers[1], .tried = numbers[2], .next = numbers[3]};
}

}  // namespace gelenk::sundials
