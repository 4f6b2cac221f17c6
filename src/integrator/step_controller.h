// SPDX-License-Identifier: BSD-3-Clause
// Step-size controller for ARKODE: the step that would have met the tolerance, or a shorter one if the errors of the
// last two steps show that the motion is becoming more demanding (Gustafsson 1994, as in Hairer & Wanner II, sec.
// IV.8).
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

// s: the step that ARKODE will try next with this controller; after a stop time, where ARKODE itself only reports the
// step cut short there. 0: no steps have been made.
double next_step(const StepController& controller, double safety, double max_growth);

// Saves or restores the data of the last step.
void serialize(const StepController& controller, Archive& archive);

}  // namespace gelenk::sundials
