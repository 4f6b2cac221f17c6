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
constexpr const char* no_evaluation =
    "this FMU changes discrete states in fmi3UpdateDiscreteStates alone (providesEvaluateDiscreteStates)";
constexpr const char* no_dependencies =
    "this FMU does not provide dependencies by element (providesPerElementDependencies): they are in "
    "modelDescription.xml";

}  // namespace
}  // namespace gelenk

using gelenk::no_dependencies;
using gelenk::no_evaluation;
using gelenk::no_event_mode;
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

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
  return refuse_feature(instance, "fmi3EnterStepMode", no_event_mode);
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) {
  return refuse_feature(instance, "fmi3EvaluateDiscreteStates", no_evaluation);
}

}  // extern "C"
