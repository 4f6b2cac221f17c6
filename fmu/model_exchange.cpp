// SPDX-License-Identifier: BSD-3-Clause
// The functions of FMI 2.0 for model exchange, where the importer integrates.
#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>

#include "fmu/api_call.h"

namespace gelenk {
namespace {

// Modes in which states, derivatives and event indicators can be read.
constexpr unsigned readable = exchanging | Mode::initialization | Mode::terminated;

template <class Body>
fmi2Status exchange(fmi2Component c, const char* function, unsigned modes, Body&& body) noexcept {
  return call(c, function, Plant::Kind::model_exchange, modes, [&](Instance& instance) {
    const StepMemory::InUse memory = instance.use_step_memory();
    return std::forward<Body>(body)(instance);
  });
}

// Throws for an array that is missing or of another length.
void expect_numbers(const char* what, size_t count, const void* array, std::size_t expected) {
  if (count != expected) {
    throw UsageError(std::string(what) + ": found " + std::to_string(count) + " numbers, expected " +
                     std::to_string(expected));
  }
  if (expected > 0 && array == nullptr) {
    throw UsageError(std::string(what) + ": found a null pointer, expected an array of " + std::to_string(expected));
  }
}

template <class T>
void expect_place(const char* what, const T* place) {
  if (place == nullptr) throw UsageError(std::string(what) + ": found a null pointer, expected a place for the result");
}

std::size_t states_of(Instance& instance) { return instance.plant().exchange().states().size(); }

}  // namespace
}  // namespace gelenk

using gelenk::Instance;
using gelenk::Mode;
using gelenk::ModelExchange;

extern "C" {

fmi2Status fmi2EnterEventMode(fmi2Component c) {
  return gelenk::exchange(c, "fmi2EnterEventMode", 0U | Mode::continuous_time, [](Instance& instance) {
    instance.enter_event_mode();
    return fmi2OK;
  });
}

// No other event follows at the same time: what one causes is part of it.
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo* info) {
  return gelenk::exchange(c, "fmi2NewDiscreteStates", 0U | Mode::event, [&](Instance& instance) {
    gelenk::expect_place("event information", info);
    const ModelExchange::Event event = instance.pass_event();
    *info = {};
    info->newDiscreteStatesNeeded = fmi2False;
    info->terminateSimulation = fmi2False;
    info->nominalsOfContinuousStatesChanged = fmi2False;
    info->valuesOfContinuousStatesChanged = event.states_changed ? fmi2True : fmi2False;
    info->nextEventTimeDefined = std::isfinite(event.next_time) ? fmi2True : fmi2False;
    info->nextEventTime = std::isfinite(event.next_time) ? event.next_time : 0;
    return fmi2OK;
  });
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
  return gelenk::exchange(c, "fmi2EnterContinuousTimeMode", 0U | Mode::event, [](Instance& instance) {
    instance.enter_continuous_time_mode();
    return fmi2OK;
  });
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean /*noSetFMUStatePriorToCurrentPoint*/,
                                       fmi2Boolean* enterEventMode, fmi2Boolean* terminateSimulation) {
  constexpr const char* name = "fmi2CompletedIntegratorStep";
  return gelenk::exchange(c, name, 0U | Mode::continuous_time, [&](Instance& instance) {
    gelenk::expect_place("enterEventMode", enterEventMode);
    gelenk::expect_place("terminateSimulation", terminateSimulation);
    *enterEventMode = instance.plant().exchange().complete_step() ? fmi2True : fmi2False;
    *terminateSimulation = fmi2False;
    return fmi2OK;
  });
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
  return gelenk::exchange(c, "fmi2SetTime", gelenk::exchanging, [&](Instance& instance) {
    instance.plant().exchange().set_time(time);
    return fmi2OK;
  });
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx) {
  return gelenk::exchange(c, "fmi2SetContinuousStates", gelenk::exchanging, [&](Instance& instance) {
    gelenk::expect_numbers("states", nx, x, gelenk::states_of(instance));
    instance.plant().exchange().set_states({x, nx});
    return fmi2OK;
  });
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx) {
  return gelenk::exchange(c, "fmi2GetDerivatives", gelenk::readable, [&](Instance& instance) {
    gelenk::expect_numbers("derivatives", nx, derivatives, gelenk::states_of(instance));
    std::ranges::copy(instance.plant().exchange().rates(), derivatives);
    return fmi2OK;
  });
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t ni) {
  return gelenk::exchange(c, "fmi2GetEventIndicators", gelenk::readable, [&](Instance& instance) {
    ModelExchange& plant = instance.plant().exchange();
    gelenk::expect_numbers("event indicators", ni, indicators, static_cast<std::size_t>(plant.indicators()));
    plant.indicator_values(indicators);
    return fmi2OK;
  });
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx) {
  return gelenk::exchange(c, "fmi2GetContinuousStates", gelenk::readable, [&](Instance& instance) {
    gelenk::expect_numbers("states", nx, x, gelenk::states_of(instance));
    std::ranges::copy(instance.plant().exchange().states(), x);
    return fmi2OK;
  });
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t nx) {
  constexpr const char* name = "fmi2GetNominalsOfContinuousStates";
  return gelenk::exchange(c, name, gelenk::readable, [&](Instance& instance) {
    gelenk::expect_numbers("nominals", nx, nominals, gelenk::states_of(instance));
    for (size_t i = 0; i < nx; ++i) nominals[i] = instance.plant().nominal(i);
    return fmi2OK;
  });
}

}  // extern "C"
