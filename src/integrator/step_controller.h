// SPDX-License-Identifier: BSD-3-Clause
// Which step ARKODE tries next: the one that would have met the tolerance, or less where the errors of the last two
// steps show that the motion is becoming harder (Gustafsson 1994, as in Hairer & Wanner II, sec. IV.8).
#pragma once

#include <sundials/sundials_adaptcontroller.h>

#include <memory>

#include "util/archive.h"

namespace gelenk::sundials {

struct DestroyController {
  void operator()(SUNAdaptController c) const { SUNAdaptController_Destroy(c); }
};
using StepController = std::unique_ptr<std::remove_pointer_t<SUNAdaptController>, DestroyController>;

StepController make_step_controller(SUNContext context);

// s: the step that ARKODE will try next with it, when at a stop time only the one cut short there is known of it; 0: it
// has not made any.
double next_step(const StepController& controller, double safety, double most_growth);

// What it remembers of the last step.
void serialize(const StepController& controller, Archive& archive);

}  // namespace gelenk::sundials
