// SPDX-License-Identifier: BSD-3-Clause
// The edge between C and C++: every FMI function runs inside call(), which no exception leaves.
#pragma once

#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <utility>

#include "fmu/floats.h"
#include "fmu/instance.h"
#include "fmu/memory.h"

namespace gelenk {

inline constexpr unsigned any_mode = ~0U;
inline constexpr unsigned before_steps = Mode::instantiated | Mode::initialization;
inline constexpr unsigned between_steps = Mode::step_complete | Mode::step_failed;
// Where values can be read: from assembly on.
inline constexpr unsigned assembled = between_steps | Mode::initialization | Mode::terminated;

// Turns the exception in flight into a status and one log line. `function` is the FMI function's name.
fmi2Status report_exception(Instance& instance, const char* function) noexcept;

// The call was made, but with the last memory: the instance can only be reset or freed. Returns fmi2Error.
fmi2Status report_out_of_memory(Instance& instance, const char* function) noexcept;

// Says why a call is refused; returns fmi2Error.
fmi2Status refuse(Instance& instance, const char* function, const std::string& why);

// Says why there is nothing to tell; returns fmi2Discard.
fmi2Status discard(Instance& instance, const char* function, const std::string& why);

// Whether the instance is in one of the modes; if not, the log says what is wrong.
bool allowed(Instance& instance, const char* function, unsigned modes) noexcept;

// An enumeration of C may hold any number, and reading one that is none of its items is undefined in C++.
template <class Enum>
int number_of(const Enum& value) noexcept {
  static_assert(sizeof(Enum) == sizeof(int));
  int number = 0;
  std::memcpy(&number, &value, sizeof number);
  return number;
}

// Runs body(instance) -> fmi2Status if the call is in order. A null component is an error without a word.
template <class Body>
fmi2Status call(fmi2Component component, const char* function, unsigned modes, Body&& body) noexcept {
  auto* instance = static_cast<Instance*>(component);
  if (instance == nullptr) return fmi2Error;
  const PlainFloats floats;
  const MemoryReserve memory;
  if (!allowed(*instance, function, modes)) return fmi2Error;
  try {
    const fmi2Status status = std::forward<Body>(body)(*instance);
    return status == fmi2OK && memory.drawn() ? report_out_of_memory(*instance, function) : status;
  } catch (...) {
    return report_exception(*instance, function);
  }
}

}  // namespace gelenk
