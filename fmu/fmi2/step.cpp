// SPDX-License-Identifier: BSD-3-Clause
// Steps and the status of the last step.
#include "fmu/step.h"
#include "fmu/api_call.h"
#include "fmu/fmi2/adapter.h"

namespace gelenk {
namespace {

constexpr unsigned stepped = between_steps | Mode::terminated;

// Returns a status value after a step; other kinds are discarded, as the standard requires.
template <class T, class Value>
fmi2Status get_status(fmi2Component c, const char* function, fmi2StatusKind kind, fmi2StatusKind known, T* value,
                      Value&& compute) noexcept {
  return as_fmi2(call(c, function, Plant::Kind::co_simulation, stepped, [&](Instance& instance) {
    if (value == nullptr)
      return refuse(instance, function, "value: found a null pointer, expected a place for the result");
    if (number_of(kind) != number_of(known))
      return discard(instance, function, "unknown kind; this FMU supports fmi2LastSuccessfulTime and fmi2Terminated");
    *value = compute(instance);
    return Status::ok;
  }));
}

// Status functions for slaves with asynchronous steps.
fmi2Status nothing_pending(fmi2Component c, const char* function) noexcept {
  return as_fmi2(call(c, function, Plant::Kind::co_simulation, stepped, [function](Instance& instance) {
    return discard(instance, function, "no step is running: fmi2DoStep returns when it is done");
  }));
}

}  // namespace
}  // namespace gelenk

using gelenk::as_fmi2;
using gelenk::Instance;

extern "C" {

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean /*noSetFMUStatePriorToCurrentPoint*/) {
  gelenk::StepResult result{};
  return as_fmi2(gelenk::do_step(c, "fmi2DoStep", {currentCommunicationPoint, communicationStepSize}, {}, result));
}

fmi2Status fmi2CancelStep(fmi2Component c) {
  constexpr const char* name = "fmi2CancelStep";
  return as_fmi2(gelenk::call(c, name, gelenk::Plant::Kind::co_simulation, gelenk::any_mode, [](Instance& instance) {
    return gelenk::refuse(instance, name, "no step is running: fmi2DoStep returns when it is done");
  }));
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind /*kind*/, fmi2Status* /*value*/) {
  return gelenk::nothing_pending(c, "fmi2GetStatus");
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real* value) {
  return gelenk::get_status(c, "fmi2GetRealStatus", kind, fmi2LastSuccessfulTime, value,
                            [](Instance& instance) { return instance.plant().time(); });
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind /*kind*/, fmi2Integer* /*value*/) {
  return gelenk::nothing_pending(c, "fmi2GetIntegerStatus");
}

// fmi2Terminated is true after a step that failed, since a master that changes nothing would repeat it forever. A
// master that sets other inputs may still continue from the last successful time. After a step that ended early because
// of its evaluation budget it is false: repeated calls make progress.
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean* value) {
  return gelenk::get_status(c, "fmi2GetBooleanStatus", kind, fmi2Terminated, value,
                            [](Instance& instance) { return instance.stuck() ? fmi2True : fmi2False; });
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind /*kind*/, fmi2String* /*value*/) {
  return gelenk::nothing_pending(c, "fmi2GetStringStatus");
}

}  // extern "C"
