// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "fmu/exchange.h"
#include "fmu/fmi3/adapter.h"

using gelenk::as_fmi3;
using gelenk::Status;

extern "C" {

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
  return as_fmi3(gelenk::enter_event_mode(instance, "fmi3EnterEventMode"));
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean* discreteStatesNeedUpdate,
                                    fmi3Boolean* terminateSimulation, fmi3Boolean* nominalsOfContinuousStatesChanged,
                                    fmi3Boolean* valuesOfContinuousStatesChanged, fmi3Boolean* nextEventTimeDefined,
                                    fmi3Float64* nextEventTime) {
  gelenk::ModelExchange::Event event;
  const Status status = gelenk::pass_event(instance, "fmi3UpdateDiscreteStates",
                                           {{"discreteStatesNeedUpdate", discreteStatesNeedUpdate},
                                            {"terminateSimulation", terminateSimulation},
                                            {"nominalsOfContinuousStatesChanged", nominalsOfContinuousStatesChanged},
                                            {"valuesOfContinuousStatesChanged", valuesOfContinuousStatesChanged},
                                            {"nextEventTimeDefined", nextEventTimeDefined},
                                            {"nextEventTime", nextEventTime}},
                                           event);
  if (status != Status::ok) return as_fmi3(status);
  const bool has_next = std::isfinite(event.next_time);
  *discreteStatesNeedUpdate = fmi3False;
  *terminateSimulation = fmi3False;
  *nominalsOfContinuousStatesChanged = fmi3False;
  *valuesOfContinuousStatesChanged = event.states_changed;
  *nextEventTimeDefined = has_next;
  *nextEventTime = has_next ? event.next_time : 0;
  return fmi3OK;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) {
  return as_fmi3(gelenk::enter_continuous_time_mode(instance, "fmi3EnterContinuousTimeMode"));
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean /*noSetFMUStatePriorToCurrentPoint*/,
                                       fmi3Boolean* enterEventMode, fmi3Boolean* terminateSimulation) {
  bool has_event = false;
  const Status status = gelenk::complete_step(
      instance, "fmi3CompletedIntegratorStep",
      {{"enterEventMode", enterEventMode}, {"terminateSimulation", terminateSimulation}}, has_event);
  if (status != Status::ok) return as_fmi3(status);
  *enterEventMode = has_event;
  *terminateSimulation = fmi3False;
  return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time) {
  return as_fmi3(gelenk::set_time(instance, "fmi3SetTime", time));
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates) {
  return as_fmi3(gelenk::set_states(instance, "fmi3SetContinuousStates", continuousStates, nContinuousStates));
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[],
                                             size_t nContinuousStates) {
  return as_fmi3(gelenk::get_rates(instance, "fmi3GetContinuousStateDerivatives", derivatives, nContinuousStates));
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[], size_t nEventIndicators) {
  return as_fmi3(gelenk::get_event_indicators(instance, "fmi3GetEventIndicators", eventIndicators, nEventIndicators));
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[], size_t nContinuousStates) {
  return as_fmi3(gelenk::get_states(instance, "fmi3GetContinuousStates", continuousStates, nContinuousStates));
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t nContinuousStates) {
  return as_fmi3(gelenk::get_nominals(instance, "fmi3GetNominalsOfContinuousStates", nominals, nContinuousStates));
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t* nEventIndicators) {
  return as_fmi3(gelenk::get_number_of_indicators(instance, "fmi3GetNumberOfEventIndicators", nEventIndicators));
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t* nContinuousStates) {
  return as_fmi3(gelenk::get_number_of_states(instance, "fmi3GetNumberOfContinuousStates", nContinuousStates));
}

}  // extern "C"
