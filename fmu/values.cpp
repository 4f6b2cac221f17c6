// SPDX-License-Identifier: BSD-3-Clause
// Reading and setting values by value reference.
#include <array>
#include <cmath>

#include "fmu/api_call.h"
#include "util/text.h"

namespace gelenk {
namespace {

const char* fmi_name(ParameterType type) {
  switch (type) {
    case ParameterType::real:
      return "Real";
    case ParameterType::boolean:
      return "Boolean";
    case ParameterType::integer:
    case ParameterType::enumeration:
      break;
  }
  return "Integer";
}

// Errors in arguments that reading and setting have in common; empty if there are none.
std::string fault(const Catalog& catalog, ParameterType type, const fmi2ValueReference* references, size_t count,
                  const void* values) {
  if (count == 0) return {};
  if (references == nullptr || values == nullptr) {
    return std::string(references == nullptr ? "value references" : "values") +
           ": found a null pointer, expected an array of " + std::to_string(count);
  }
  for (size_t i = 0; i < count; ++i) {
    const Variable* v = catalog.find(references[i]);
    if (v == nullptr) {
      return "value reference: found " + std::to_string(references[i]) + ", expected less than " +
             std::to_string(catalog.variables().size());
    }
    if (v->type != type && !(type == ParameterType::integer && v->type == ParameterType::enumeration))
      return v->name + " is of type " + fmi_name(v->type);
  }
  return {};
}

template <class T>
fmi2Status get(fmi2Component c, const char* function, ParameterType type, const fmi2ValueReference* references,
               size_t count, T* values) noexcept {
  return call(c, function, assembled | Mode::instantiated, [&](Instance& instance) {
    const StepMemory::InUse memory = instance.use_step_memory();
    Plant& plant = instance.plant();
    const std::string why = fault(plant.catalog(), type, references, count, values);
    if (!why.empty()) return refuse(instance, function, why);
    for (size_t i = 0; i < count; ++i) {
      const Variable& v = plant.catalog().variables()[references[i]];
      const bool set_by_master = v.source == Source::input || v.source == Source::parameter;
      if (instance.mode() == Mode::instantiated && !set_by_master) {
        return refuse(instance, function, v.name + " can be read only after fmi2EnterInitializationMode");
      }
      values[i] = static_cast<T>(plant.get(static_cast<int>(references[i])));
    }
    return fmi2OK;
  });
}

// All values are checked before the first one is set, so that a call sets all of them or none.
template <class T>
fmi2Status set(fmi2Component c, const char* function, ParameterType type, const fmi2ValueReference* references,
               size_t count, const T* values) noexcept {
  return call(c, function, before_steps | running, [&](Instance& instance) {
    const StepMemory::InUse memory = instance.use_step_memory();
    Plant& plant = instance.plant();
    const std::string why = fault(plant.catalog(), type, references, count, values);
    if (!why.empty()) return refuse(instance, function, why);
    const bool runs = (running & static_cast<unsigned>(instance.mode())) != 0;
    for (size_t i = 0; i < count; ++i) {
      const Variable& v = plant.catalog().variables()[references[i]];
      if (runs && v.variability == Variability::fixed) {
        return refuse(instance, function,
                      v.name + " is a fixed parameter: it can be set only before fmi2ExitInitializationMode");
      }
      if (instance.mode() == Mode::continuous_time && v.variability == Variability::tunable)
        return refuse(instance, function, v.name + " is a tunable parameter: it can be set only in event mode");
      if (!runs && v.source != Source::input && v.source != Source::parameter)
        return refuse(instance, function, v.name + " is computed by the plant and cannot be set");
      plant.check(static_cast<int>(references[i]), static_cast<double>(values[i]));
    }
    for (size_t i = 0; i < count; ++i) {
      const int variable = static_cast<int>(references[i]);
      const auto value = static_cast<double>(values[i]);
      runs ? plant.tune(variable, value) : plant.set(variable, value);
    }
    return fmi2OK;
  });
}

fmi2Status set_derivatives(fmi2Component c, const char* function, const fmi2ValueReference* references, size_t count,
                           const fmi2Integer* orders, const fmi2Real* values) noexcept {
  return call(c, function, Plant::Kind::co_simulation, before_steps | between_steps, [&](Instance& instance) {
    const StepMemory::InUse memory = instance.use_step_memory();
    Plant& plant = instance.plant();
    const std::string why = fault(plant.catalog(), ParameterType::real, references, count, values);
    if (!why.empty()) return refuse(instance, function, why);
    if (count > 0 && orders == nullptr) {
      return refuse(instance, function, "orders: found a null pointer, expected an array of " + std::to_string(count));
    }
    for (size_t i = 0; i < count; ++i) {
      plant.check_input_derivative(static_cast<int>(references[i]), orders[i], values[i]);
    }
    for (size_t i = 0; i < count; ++i) {
      plant.set_input_derivative(static_cast<int>(references[i]), orders[i], values[i]);
    }
    return fmi2OK;
  });
}

// No variable is a String, so any reference is invalid.
fmi2Status strings(fmi2Component c, const char* function, size_t count) noexcept {
  return call(c, function, any_mode, [&](Instance& instance) {
    return count == 0 ? fmi2OK : refuse(instance, function, "this FMU has no variables of type String");
  });
}

}  // namespace
}  // namespace gelenk

using gelenk::ParameterType;

extern "C" {

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[]) {
  return gelenk::get(c, "fmi2GetReal", ParameterType::real, vr, nvr, value);
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[]) {
  return gelenk::get(c, "fmi2GetInteger", ParameterType::integer, vr, nvr, value);
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[]) {
  return gelenk::get(c, "fmi2GetBoolean", ParameterType::boolean, vr, nvr, value);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference /*vr*/[], size_t nvr, fmi2String /*value*/[]) {
  return gelenk::strings(c, "fmi2GetString", nvr);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[]) {
  return gelenk::set(c, "fmi2SetReal", ParameterType::real, vr, nvr, value);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer value[]) {
  return gelenk::set(c, "fmi2SetInteger", ParameterType::integer, vr, nvr, value);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Boolean value[]) {
  return gelenk::set(c, "fmi2SetBoolean", ParameterType::boolean, vr, nvr, value);
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[]) {
  return gelenk::set_derivatives(c, "fmi2SetRealInputDerivatives", vr, nvr, order, value);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference /*vr*/[], size_t nvr, const fmi2String /*value*/[]) {
  return gelenk::strings(c, "fmi2SetString", nvr);
}

}  // extern "C"
