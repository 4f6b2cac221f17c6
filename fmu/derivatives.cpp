// SPDX-License-Identifier: BSD-3-Clause
// Derivatives of outputs and states with respect to states, inputs and time.
#include "fmu/runtime/plant_derivatives.h"

#include "fmu/api_call.h"

namespace gelenk {
namespace {

// Throws for a missing list.
void expect(const char* what, size_t count, const void* list) {
  if (count > 0 && list == nullptr) {
    throw UsageError(std::string(what) + ": found a null pointer, expected an array of " + std::to_string(count));
  }
}

template <class Body>
fmi2Status differentiate(fmi2Component c, const char* function, unsigned modes, Body&& body) noexcept {
  return call(c, function, modes, [&](Instance& instance) {
    const StepMemory::InUse memory = instance.use_step_memory();
    try {
      std::forward<Body>(body)(instance.plant());
      return fmi2OK;
    } catch (const NotDifferentiable& fault) {
      return discard(instance, function, fault.what());
    }
  });
}

}  // namespace
}  // namespace gelenk

using gelenk::Plant;

extern "C" {

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t nUnknown,
                                        const fmi2ValueReference known[], size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[]) {
  return gelenk::differentiate(c, "fmi2GetDirectionalDerivative", gelenk::assembled, [&](Plant& plant) {
    gelenk::expect("unknowns", nUnknown, unknown);
    gelenk::expect("knowns", nKnown, known);
    gelenk::expect("dvKnown", nKnown, dvKnown);
    gelenk::expect("dvUnknown", nUnknown, dvUnknown);
    if (nUnknown == 0) return;
    gelenk::directional_derivative(plant, {unknown, nUnknown}, {known, nKnown}, dvKnown, dvUnknown);
  });
}

// A function of co-simulation. FMI permits this call only after steps; Maestro also makes it in initialization mode,
// where the values are known, too.
fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[]) {
  constexpr const char* name = "fmi2GetRealOutputDerivatives";
  if (c != nullptr && !gelenk::is_of_kind(*static_cast<gelenk::Instance*>(c), name, Plant::Kind::co_simulation))
    return fmi2Error;
  return gelenk::differentiate(c, name, gelenk::assembled, [&](Plant& plant) {
    gelenk::expect("value references", nvr, vr);
    gelenk::expect("orders", nvr, order);
    gelenk::expect("values", nvr, value);
    if (nvr > 0) gelenk::output_derivatives(plant, {vr, nvr}, order, value);
  });
}

}  // extern "C"
