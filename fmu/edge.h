// SPDX-License-Identifier: BSD-3-Clause
// The edge between C and C++: every FMI function runs inside call(), which no exception leaves.
#pragma once

#include <exception>
#include <new>
#include <string>
#include <utility>

#include "fmu/instance.h"

namespace gelenk {

inline constexpr unsigned any_mode = ~0U;
inline constexpr unsigned before_steps = Mode::instantiated | Mode::initialization;
inline constexpr unsigned between_steps = Mode::step_complete | Mode::step_failed;
// Where values can be read: from assembly on.
inline constexpr unsigned assembled = between_steps | Mode::initialization | Mode::terminated;

// Turns the exception in flight into a status and one log line. `function` is the FMI function's name.
fmi2Status report_exception(Instance& instance, const char* function) noexcept;

// Says why a call is refused; returns fmi2Error.
fmi2Status refuse(Instance& instance, const char* function, const std::string& why);

// Whether the instance is in one of the modes; if not, the log says what is wrong.
bool allowed(Instance& instance, const char* function, unsigned modes) noexcept;

// Runs body(instance) -> fmi2Status if the call is in order. A null component is an error without a word.
template <class Body>
fmi2Status call(fmi2Component component, const char* function, unsigned modes, Body&& body) noexcept {
  auto* instance = static_cast<Instance*>(component);
  if (instance == nullptr) return fmi2Error;
  if (!allowed(*instance, function, modes)) return fmi2Error;
  try {
    return std::forward<Body>(body)(*instance);
  } catch (...) {
    return report_exception(*instance, function);
  }
}

}  // namespace gelenk
