// SPDX-License-Identifier: BSD-3-Clause
// The functions of FMI 2.0 for model exchange, which this FMU does not support.
#include "fmu/api_call.h"

namespace gelenk {
namespace {

fmi2Status model_exchange_only(fmi2Component c, const char* function) noexcept {
  return call(c, function, any_mode, [&](Instance& instance) {
    return refuse(instance, function, "is a function for model exchange; this FMU is for co-simulation");
  });
}

}  // namespace
}  // namespace gelenk

using gelenk::model_exchange_only;

extern "C" {

fmi2Status fmi2EnterEventMode(fmi2Component c) { return model_exchange_only(c, "fmi2EnterEventMode"); }
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo* /*info*/) {
  return model_exchange_only(c, "fmi2NewDiscreteStates");
}
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
  return model_exchange_only(c, "fmi2EnterContinuousTimeMode");
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean /*noSetFMUStatePriorToCurrentPoint*/,
                                       fmi2Boolean* /*enterEventMode*/, fmi2Boolean* /*terminateSimulation*/) {
  return model_exchange_only(c, "fmi2CompletedIntegratorStep");
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real /*time*/) { return model_exchange_only(c, "fmi2SetTime"); }
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real /*x*/[], size_t /*nx*/) {
  return model_exchange_only(c, "fmi2SetContinuousStates");
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real /*derivatives*/[], size_t /*nx*/) {
  return model_exchange_only(c, "fmi2GetDerivatives");
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real /*indicators*/[], size_t /*ni*/) {
  return model_exchange_only(c, "fmi2GetEventIndicators");
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real /*x*/[], size_t /*nx*/) {
  return model_exchange_only(c, "fmi2GetContinuousStates");
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real /*nominals*/[], size_t /*nx*/) {
  return model_exchange_only(c, "fmi2GetNominalsOfContinuousStates");
}

}  // extern "C"
