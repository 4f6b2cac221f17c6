// SPDX-License-Identifier: BSD-3-Clause
// Stepping, and what became of the last step.
#include "fmu/api_call.h"

namespace gelenk {
namespace {

constexpr unsigned stepped = between_steps | Mode::terminated;

// Tells a fact after a step; kinds this FMU has nothing to tell of are discarded, as the standard asks.
template <class T, class Value>
fmi2Status get_status(fmi2Component c, const char* function, fmi2StatusKind kind, fmi2StatusKind known, T* value,
                      Value&& fact) noexcept {
  return call(c, function, stepped, [&](Instance& instance) {
    if (value == nullptr) return refuse(instance, function, "value: found nothing, expected where to write it");
    if (number_of(kind) != number_of(known))
      return discard(instance, function, "not known; this FMU tells fmi2LastSuccessfulTime and fmi2Terminated");
    *value = fact(instance);
    return fmi2OK;
  });
}

// Statuses that only a slave with steps running in the background has.
fmi2Status nothing_pending(fmi2Component c, const char* function) noexcept {
  return call(c, function, stepped, [function](Instance& instance) {
    return discard(instance, function, "no step is running: fmi2DoStep returns when it is done");
  });
}

}  // namespace
}  // namespace gelenk

using gelenk::Instance;

extern "C" {

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean /*noSetFMUStatePriorToCurrentPoint*/) {
  return gelenk::call(c, "fmi2DoStep", gelenk::between_steps, [&](Instance& instance) {
    instance.step(currentCommunicationPoint, communicationStepSize);
    return fmi2OK;
  });
}

fmi2Status fmi2CancelStep(fmi2Component c) {
  return gelenk::call(c, "fmi2CancelStep", gelenk::any_mode, [](Instance& instance) {
    return gelenk::refuse(instance, "fmi2CancelStep", "no step is running: fmi2DoStep returns when it is done");
  });
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

// After a step that could not be made the wish to end is true: a master that changes nothing would try the same step
// for ever. One that sets other inputs may go on from the last successful time all the same. A step cut short is no
// reason to end: there is a way on, and each call goes part of it.
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean* value) {
  return gelenk::get_status(c, "fmi2GetBooleanStatus", kind, fmi2Terminated, value,
                            [](Instance& instance) { return instance.stuck() ? fmi2True : fmi2False; });
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind /*kind*/, fmi2String* /*value*/) {
  return gelenk::nothing_pending(c, "fmi2GetStringStatus");
}

}  // extern "C"
