// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "fmu/exchange.h"
#include "fmu/fmi2/adapter.h"

using gelenk::as_fmi2;
using gelenk::fmi2_boolean;
using gelenk::Status;

extern "C" {

fmi2Status fmi2EnterEventMode(fmi2Component c) { return as_fmi2(gelenk::enter_event_mode(c, "fmi2EnterEventMode")); }

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo* info) {
  gelenk::ModelExchange::Event event;
  const Status status = gelenk::pass_event(c, "fmi2NewDiscreteStates", {{"event information", info}}, event);
  if (status != Status::ok) return as_fmi2(status);
  const bool has_next = std::isfinite(event.next_time);
  *info = {};
  info->newDiscreteStatesNeeded = fmi2False;
  info->terminateSimulation = fmi2False;
  info->nominalsOfContinuousStatesChanged = fmi2False;
  info->valuesOfContinuousStatesChanged = fmi2_boolean(event.states_changed);
  info->nextEventTimeDefined = fmi2_boolean(has_next);
  info->nextEventTime = has_next ? event.next_time : 0;
  return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
  return as_fmi2(gelenk::enter_continuous_time_mode(c, "fmi2EnterContinuousTimeMode"));
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean /*noSetFMUStatePriorToCurrentPoint*/,
                                       fmi2Boolean* enterEventMode, fmi2Boolean* terminateSimulation) {
  bool has_event = false;
  const Status status = gelenk::complete_step(
      c, "fmi2CompletedIntegratorStep",
      {{"enterEventMode", enterEventMode}, {"terminateSimulation", terminateSimulation}}, has_event);
  if (status != Status::ok) return as_fmi2(status);
  *enterEventMode = fmi2_boolean(has_event);
  *terminateSimulation = fmi2False;
  return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) { return as_fmi2(gelenk::set_time(c, "fmi2SetTime", time)); }

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx) {
  return as_fmi2(gelenk::set_states(c, "fmi2SetContinuousStates", x, nx));
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx) {
  return as_fmi2(gelenk::get_rates(c, "fmi2GetDerivatives", derivatives, nx));
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t ni) {
  return as_fmi2(gelenk::get_event_indicators(c, "fmi2GetEventIndicators", indicators, ni));
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx) {
  return as_fmi2(gelenk::get_states(c, "fmi2GetContinuousStates", x, nx));
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t nx) {
  return as_fmi2(gelenk::get_nominals(c, "fmi2GetNominalsOfContinuousStates", nominals, nx));
}

}  // extern "C"
