// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/values.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "fmu/api_call.h"
#include "util/text.h"

namespace gelenk {
namespace {

const char* fmi_name(ParameterType type, const Vocabulary& vocabulary) {
  switch (type) {
    case ParameterType::real:
      return vocabulary.real;
    case ParameterType::boolean:
      return "Boolean";
    case ParameterType::integer:
      return vocabulary.integer;
    case ParameterType::enumeration:
      break;
  }
  return vocabulary.enumeration;
}

// How many variables for event indicators follow those of the catalog.
std::size_t indicators_of(Instance& instance) {
  if (!instance.interface().indicators_are_variables) return 0;
  return static_cast<std::size_t>(instance.plant().model().indicators());
}

// Whether a value reference beyond the catalog is one of an event indicator.
bool is_indicator(Instance& instance, unsigned reference) {
  return reference - instance.plant().catalog().variables().size() < indicators_of(instance);
}

std::string name_of_indicator(Instance& instance, unsigned reference) {
  return "event_indicators[" + std::to_string(reference - instance.plant().catalog().variables().size() + 1) + "]";
}

// Errors in arguments that reading and setting have in common; empty if there are none.
std::string fault(Instance& instance, const ValueCall& of, const void* values) {
  const Catalog& catalog = instance.plant().catalog();
  if (of.values != of.count) {
    return "values: found an array of " + std::to_string(of.values) + ", expected one of " + std::to_string(of.count) +
           ", a value for each value reference";
  }
  if (of.count == 0) return {};
  if (of.references == nullptr || values == nullptr) {
    return std::string(of.references == nullptr ? "value references" : "values") +
           ": found a null pointer, expected an array of " + std::to_string(of.count);
  }
  for (std::size_t i = 0; i < of.count; ++i) {
    const Variable* v = catalog.find(of.references[i]);
    if (v == nullptr && is_indicator(instance, of.references[i])) {
      if (of.types.type == ParameterType::real) continue;
      return name_of_indicator(instance, of.references[i]) + " is of type " + instance.interface().vocabulary.real;
    }
    if (v == nullptr) {
      return "value reference: found " + std::to_string(of.references[i]) + ", expected less than " +
             std::to_string(catalog.variables().size() + indicators_of(instance));
    }
    if (v->type != of.types.type && v->type != of.types.other)
      return v->name + " is of type " + fmi_name(v->type, instance.interface().vocabulary);
  }
  return {};
}

// Why a variable cannot be set now; empty if it can.
std::string fault_of_setting(const Instance& instance, const Variable& v, bool runs) {
  if (runs && v.variability == Variability::fixed) {
    return v.name + " is a fixed parameter: it can be set only before " +
           instance.interface().vocabulary.exit_initialization;
  }
  if (instance.mode() == Mode::continuous_time && v.variability == Variability::tunable)
    return v.name + " is a tunable parameter: it can be set only in event mode";
  if (!runs && v.source != Source::input && v.source != Source::parameter)
    return v.name + " is computed by the plant and cannot be set";
  return {};
}

}  // namespace

template <class T>
Status get_values(void* instance, const ValueCall& call_of, T* values) noexcept {
  return call(instance, call_of.function, assembled | Mode::instantiated, [&](Instance& of) {
    const StepMemory::InUse memory = of.use_step_memory();
    Plant& plant = of.plant();
    const std::string why = fault(of, call_of, values);
    if (!why.empty()) return refuse(of, call_of.function, why);
    std::vector<double> indicators;
    for (std::size_t i = 0; i < call_of.count; ++i) {
      const unsigned reference = call_of.references[i];
      const Variable* v = plant.catalog().find(reference);
      const bool set_by_master = v != nullptr && (v->source == Source::input || v->source == Source::parameter);
      if (of.mode() == Mode::instantiated && !set_by_master) {
        return refuse(of, call_of.function,
                      (v != nullptr ? v->name : name_of_indicator(of, reference)) + " can be read only after " +
                          of.interface().vocabulary.enter_initialization);
      }
      if (v != nullptr) {
        values[i] = static_cast<T>(plant.get(static_cast<int>(reference)));
      } else {
        if (indicators.empty()) indicators = plant.indicator_values();
        values[i] = static_cast<T>(indicators[reference - plant.catalog().variables().size()]);
      }
    }
    return Status::ok;
  });
}

template <class T>
Status set_values(void* instance, const ValueCall& call_of, const T* values) noexcept {
  return call(instance, call_of.function, before_steps | running, [&](Instance& of) {
    const StepMemory::InUse memory = of.use_step_memory();
    Plant& plant = of.plant();
    std::string why = fault(of, call_of, values);
    if (!why.empty()) return refuse(of, call_of.function, why);
    const bool runs = (running & static_cast<unsigned>(of.mode())) != 0;
    for (std::size_t i = 0; i < call_of.count; ++i) {
      const unsigned reference = call_of.references[i];
      const Variable* v = plant.catalog().find(reference);
      why = v != nullptr ? fault_of_setting(of, *v, runs)
                         : name_of_indicator(of, reference) + " is computed by the plant and cannot be set";
      if (!why.empty()) return refuse(of, call_of.function, why);
      plant.check(static_cast<int>(reference), static_cast<double>(values[i]));
    }
    for (std::size_t i = 0; i < call_of.count; ++i) {
      const int variable = static_cast<int>(call_of.references[i]);
      const auto value = static_cast<double>(values[i]);
      runs ? plant.tune(variable, value) : plant.set(variable, value);
    }
    return Status::ok;
  });
}

template Status get_values(void*, const ValueCall&, double*) noexcept;
template Status get_values(void*, const ValueCall&, std::int32_t*) noexcept;
template Status get_values(void*, const ValueCall&, std::int64_t*) noexcept;
template Status get_values(void*, const ValueCall&, bool*) noexcept;
template Status set_values(void*, const ValueCall&, const double*) noexcept;
template Status set_values(void*, const ValueCall&, const std::int32_t*) noexcept;
template Status set_values(void*, const ValueCall&, const std::int64_t*) noexcept;
template Status set_values(void*, const ValueCall&, const unsigned char*) noexcept;

Status set_input_derivatives(void* instance, const ValueCall& call_of, const int* orders,
                             const double* values) noexcept {
  constexpr unsigned modes = before_steps | between_steps;
  return call(instance, call_of.function, Plant::Kind::co_simulation, modes, [&](Instance& of) {
    const StepMemory::InUse memory = of.use_step_memory();
    Plant& plant = of.plant();
    const std::string why = fault(of, call_of, values);
    if (!why.empty()) return refuse(of, call_of.function, why);
    if (call_of.count > 0 && orders == nullptr) {
      return refuse(of, call_of.function,
                    "orders: found a null pointer, expected an array of " + std::to_string(call_of.count));
    }
    for (std::size_t i = 0; i < call_of.count; ++i) {
      plant.check_input_derivative(static_cast<int>(call_of.references[i]), orders[i], values[i]);
    }
    for (std::size_t i = 0; i < call_of.count; ++i) {
      plant.set_input_derivative(static_cast<int>(call_of.references[i]), orders[i], values[i]);
    }
    return Status::ok;
  });
}

Status refuse_type(void* instance, const char* function, const char* type, std::size_t count) noexcept {
  return call(instance, function, any_mode, [&](Instance& of) {
    return count == 0 ? Status::ok : refuse(of, function, std::string("this FMU has no variables of type ") + type);
  });
}

}  // namespace gelenk
