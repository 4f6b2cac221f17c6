// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/derivatives.h"

#include "fmu/api_call.h"
#include "fmu/runtime/plant_derivatives.h"

namespace gelenk {
namespace {

// Throws for a list that is missing or of another length.
template <class T>
void expect(const ListArgument<T>& list, std::size_t count) {
  if (list.count != count) {
    throw UsageError(std::string(list.name) + ": found an array of " + std::to_string(list.count) +
                     ", expected one of " + std::to_string(count));
  }
  if (count > 0 && list.values == nullptr) {
    throw UsageError(std::string(list.name) + ": found a null pointer, expected an array of " + std::to_string(count));
  }
}

References span_of(const ReferenceList& list) { return {list.values, list.count}; }

template <class Body>
Status differentiate(void* c, const char* function, Body&& body) noexcept {
  return call(c, function, assembled, [&](Instance& instance) {
    const StepMemory::InUse memory = instance.use_step_memory();
    try {
      std::forward<Body>(body)(instance.plant());
      return Status::ok;
    } catch (const NotDifferentiable& fault) {
      return discard(instance, function, fault.what());
    }
  });
}

}  // namespace

Status get_directional_derivative(void* instance, const char* function, const ReferenceList& unknowns,
                                  const ReferenceList& knowns, const Seed& seed, const Sensitivities& out) noexcept {
  return differentiate(instance, function, [&](Plant& plant) {
    expect(unknowns, unknowns.count);
    expect(knowns, knowns.count);
    expect(seed, knowns.count);
    expect(out, unknowns.count);
    if (unknowns.count == 0) return;
    directional_derivative(plant, span_of(unknowns), span_of(knowns), {seed.name, seed.values}, out.values);
  });
}

Status get_adjoint_derivative(void* instance, const char* function, const ReferenceList& unknowns,
                              const ReferenceList& knowns, const Seed& seed, const Sensitivities& out) noexcept {
  return differentiate(instance, function, [&](Plant& plant) {
    expect(unknowns, unknowns.count);
    expect(knowns, knowns.count);
    expect(seed, unknowns.count);
    expect(out, knowns.count);
    if (knowns.count == 0) return;
    adjoint_derivative(plant, span_of(unknowns), span_of(knowns), {seed.name, seed.values}, out.values);
  });
}

Status get_output_derivatives(void* instance, const char* function, const ReferenceList& outputs, const int* orders,
                              const Sensitivities& out) noexcept {
  if (instance != nullptr && !is_of_kind(*static_cast<Instance*>(instance), function, Plant::Kind::co_simulation))
    return Status::error;
  return differentiate(instance, function, [&](Plant& plant) {
    expect(outputs, outputs.count);
    expect(ListArgument<const int>{"orders", orders, outputs.count}, outputs.count);
    expect(out, outputs.count);
    if (outputs.count > 0) output_derivatives(plant, span_of(outputs), orders, out.values);
  });
}

}  // namespace gelenk
