// SPDX-License-Identifier: BSD-3-Clause
// Functions for what the FMU does not have: each says what there is instead.
#include "fmu/api_call.h"
#include "fmu/fmi3/adapter.h"

namespace gelenk {
namespace {

fmi3Status refuse_feature(fmi3Instance instance, const char* function, const char* why) noexcept {
  return as_fmi3(call(instance, function, any_mode, [&](Instance& of) { return refuse(of, function, why); }));
}

constexpr const char* no_event_mode =
    "this FMU has no event mode in co-simulation (hasEventMode): events are passed within fmi3DoStep";
constexpr const char* no_dependencies =
    "this FMU does not provide dependencies by element (providesPerElementDependencies): they are in "
    "modelDescription.xml";
constexpr const char* no_exchange = "this FMU is for co-simulation";

}  // namespace
}  // namespace gelenk

using gelenk::no_dependencies;
using gelenk::no_event_mode;
using gelenk::no_exchange;
using gelenk::refuse_feature;

extern "C" {

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference /*valueReference*/,
                                               size_t* /*nDependencies*/) {
  return refuse_feature(instance, "fmi3GetNumberOfVariableDependencies", no_dependencies);
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference /*dependent*/,
                                       size_t /*elementIndicesOfDependent*/[], fmi3ValueReference /*independents*/[],
                                       size_t /*elementIndicesOfIndependents*/[],
                                       fmi3DependencyKind /*dependencyKinds*/[], size_t /*nDependencies*/) {
  return refuse_feature(instance, "fmi3GetVariableDependencies", no_dependencies);
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
  return refuse_feature(instance, "fmi3EnterEventMode", no_event_mode);
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
  return refuse_feature(instance, "fmi3EnterStepMode", no_event_mode);
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) {
  return refuse_feature(instance, "fmi3EvaluateDiscreteStates", no_event_mode);
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean* /*discreteStatesNeedUpdate*/,
                                    fmi3Boolean* /*terminateSimulation*/,
                                    fmi3Boolean* /*nominalsOfContinuousStatesChanged*/,
                                    fmi3Boolean* /*valuesOfContinuousStatesChanged*/,
                                    fmi3Boolean* /*nextEventTimeDefined*/, fmi3Float64* /*nextEventTime*/) {
  return refuse_feature(instance, "fmi3UpdateDiscreteStates", no_event_mode);
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) {
  return refuse_feature(instance, "fmi3EnterContinuousTimeMode", no_exchange);
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean /*noSetFMUStatePriorToCurrentPoint*/,
                                       fmi3Boolean* /*enterEventMode*/, fmi3Boolean* /*terminateSimulation*/) {
  return refuse_feature(instance, "fmi3CompletedIntegratorStep", no_exchange);
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 /*time*/) {
  return refuse_feature(instance, "fmi3SetTime", no_exchange);
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 /*continuousStates*/[],
                                   size_t /*nContinuousStates*/) {
  return refuse_feature(instance, "fmi3SetContinuousStates", no_exchange);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 /*derivatives*/[],
                                             size_t /*nContinuousStates*/) {
  return refuse_feature(instance, "fmi3GetContinuousStateDerivatives", no_exchange);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 /*eventIndicators*/[],
                                  size_t /*nEventIndicators*/) {
  return refuse_feature(instance, "fmi3GetEventIndicators", no_exchange);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 /*continuousStates*/[],
                                   size_t /*nContinuousStates*/) {
  return refuse_feature(instance, "fmi3GetContinuousStates", no_exchange);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 /*nominals*/[],
                                             size_t /*nContinuousStates*/) {
  return refuse_feature(instance, "fmi3GetNominalsOfContinuousStates", no_exchange);
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t* /*nEventIndicators*/) {
  return refuse_feature(instance, "fmi3GetNumberOfEventIndicators", no_exchange);
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t* /*nContinuousStates*/) {
  return refuse_feature(instance, "fmi3GetNumberOfContinuousStates", no_exchange);
}

}  // extern "C"
