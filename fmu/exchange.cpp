// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/exchange.h"

#include <algorithm>
#include <string>
#include <utility>

#include "fmu/api_call.h"

namespace gelenk {
namespace {

// Modes in which states, derivatives and event indicators can be read.
constexpr unsigned readable = exchanging | Mode::initialization | Mode::terminated;

// Runs body(instance), which throws what it refuses.
template <class Body>
Status exchange(void* c, const char* function, unsigned modes, Body&& body) noexcept {
  return call(c, function, Plant::Kind::model_exchange, modes, [&](Instance& instance) {
    const StepMemory::InUse memory = instance.use_step_memory();
    std::forward<Body>(body)(instance);
    return Status::ok;
  });
}

// Throws for an array that is missing or of another length.
void expect_numbers(const char* what, std::size_t count, const void* array, std::size_t expected) {
  if (count != expected) {
    throw UsageError(std::string(what) + ": found " + std::to_string(count) + " numbers, expected " +
                     std::to_string(expected));
  }
  if (expected > 0 && array == nullptr) {
    throw UsageError(std::string(what) + ": found a null pointer, expected an array of " + std::to_string(expected));
  }
}

std::size_t states_of(Instance& instance) { return instance.plant().exchange().states().size(); }

}  // namespace

Status enter_event_mode(void* instance, const char* function) noexcept {
  return exchange(instance, function, 0U | Mode::continuous_time, [](Instance& of) { of.enter_event_mode(); });
}

Status pass_event(void* instance, const char* function, std::initializer_list<Place> results,
                  ModelExchange::Event& event) noexcept {
  return exchange(instance, function, 0U | Mode::event, [&](Instance& of) {
    expect_places(results);
    event = of.pass_event();
  });
}

Status enter_continuous_time_mode(void* instance, const char* function) noexcept {
  return exchange(instance, function, 0U | Mode::event, [](Instance& of) { of.enter_continuous_time_mode(); });
}

Status complete_step(void* instance, const char* function, std::initializer_list<Place> results,
                     bool& has_event) noexcept {
  return exchange(instance, function, 0U | Mode::continuous_time, [&](Instance& of) {
    expect_places(results);
    has_event = of.plant().exchange().complete_step();
  });
}

Status set_time(void* instance, const char* function, double time) noexcept {
  return exchange(instance, function, exchanging, [&](Instance& of) { of.plant().exchange().set_time(time); });
}

Status set_states(void* instance, const char* function, const double* states, std::size_t count) noexcept {
  return exchange(instance, function, exchanging, [&](Instance& of) {
    expect_numbers("states", count, states, states_of(of));
    of.plant().exchange().set_states({states, count});
  });
}

Status get_states(void* instance, const char* function, double* states, std::size_t count) noexcept {
  return exchange(instance, function, readable, [&](Instance& of) {
    expect_numbers("states", count, states, states_of(of));
    std::ranges::copy(of.plant().exchange().states(), states);
  });
}

Status get_rates(void* instance, const char* function, double* rates, std::size_t count) noexcept {
  return exchange(instance, function, readable, [&](Instance& of) {
    expect_numbers("derivatives", count, rates, states_of(of));
    std::ranges::copy(of.plant().exchange().rates(), rates);
  });
}

Status get_nominals(void* instance, const char* function, double* nominals, std::size_t count) noexcept {
  return exchange(instance, function, readable, [&](Instance& of) {
    expect_numbers("nominals", count, nominals, states_of(of));
    for (std::size_t i = 0; i < count; ++i) nominals[i] = of.plant().nominal(i);
  });
}

Status get_number_of_states(void* instance, const char* function, std::size_t* count) noexcept {
  return exchange(instance, function, readable | Mode::instantiated, [&](Instance& of) {
    expect_places({{"number", count}});
    *count = of.plant().model().states().catalog.states().size();
  });
}

Status get_number_of_indicators(void* instance, const char* function, std::size_t* count) noexcept {
  return exchange(instance, function, readable | Mode::instantiated, [&](Instance& of) {
    expect_places({{"number", count}});
    *count = static_cast<std::size_t>(of.plant().exchange().indicators());
  });
}

Status get_event_indicators(void* instance, const char* function, double* indicators, std::size_t count) noexcept {
  return exchange(instance, function, readable, [&](Instance& of) {
    ModelExchange& plant = of.plant().exchange();
    expect_numbers("event indicators", count, indicators, static_cast<std::size_t>(plant.indicators()));
    plant.indicator_values(indicators);
  });
}

}  // namespace gelenk
