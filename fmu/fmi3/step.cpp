// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/step.h"

#include <array>
#include <string>

#include "fmu/api_call.h"
#include "fmu/fmi3/adapter.h"

extern "C" {

// Events are passed within the step, so that none is left to the importer. The simulation need not be ended after a
// step that failed, but a master that changes nothing would repeat it forever.
fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean /*noSetFMUStatePriorToCurrentPoint*/, fmi3Boolean* eventHandlingNeeded,
                      fmi3Boolean* terminateSimulation, fmi3Boolean* earlyReturn, fmi3Float64* lastSuccessfulTime) {
  constexpr const char* name = "fmi3DoStep";
  gelenk::StepResult result{};
  const gelenk::Status status = gelenk::do_step(instance, name, {currentCommunicationPoint, communicationStepSize},
                                                {{"eventHandlingNeeded", eventHandlingNeeded},
                                                 {"terminateSimulation", terminateSimulation},
                                                 {"earlyReturn", earlyReturn},
                                                 {"lastSuccessfulTime", lastSuccessfulTime}},
                                                result);
  if (status == gelenk::Status::error) return fmi3Error;
  *eventHandlingNeeded = fmi3False;
  *terminateSimulation = result.is_futile;
  *earlyReturn = result.is_early;
  *lastSuccessfulTime = result.time_reached;
  return gelenk::as_fmi3(status);
}

}  // extern "C"
