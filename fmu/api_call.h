// SPDX-License-Identifier: BSD-3-Clause
// The interface between C and C++: every FMI function runs inside call(), which throws no exceptions.
#pragma once

#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <utility>

#include "fmu/floating_point_guard.h"
#include "fmu/instance.h"
#include "fmu/memory.h"

namespace gelenk {

inline constexpr unsigned any_mode = ~0U;
inline constexpr unsigned before_steps = Mode::instantiated | Mode::initialization;
inline constexpr unsigned running = between_steps | exchanging;
// Modes in which computed values can be read.
inline constexpr unsigned assembled = running | Mode::initialization | Mode::terminated;

// Converts the current exception to a status and one log message. function: name of the FMI function.
Status report_exception(Instance& instance, const char* function) noexcept;

// Logs that memory ran out; afterwards the instance can only be reset or freed. Returns Status::error.
Status report_out_of_memory(Instance& instance, const char* function) noexcept;

// Logs why a call is invalid; returns Status::error.
Status refuse(Instance& instance, const char* function, const std::string& why);

// Logs why a result does not exist; returns Status::discard.
Status discard(Instance& instance, const char* function, const std::string& why);

// Logs a warning about what has been done.
void warn(Instance& instance, const char* function, const std::string& what) noexcept;

// Whether the instance is in one of the modes; if not, logs an error.
bool allowed(Instance& instance, const char* function, unsigned modes) noexcept;

// Whether the instance is of the kind whose function this is; if not, logs an error.
bool is_of_kind(Instance& instance, const char* function, Plant::Kind kind) noexcept;

// The number of an enumeration item. C callers may pass any number, and reading one that is not an item is undefined
// behavior in C++.
template <class Enum>
int number_of(const Enum& value) noexcept {
  static_assert(sizeof(Enum) == sizeof(int));
  int number = 0;
  std::memcpy(&number, &value, sizeof number);
  return number;
}

// Runs body(instance) -> Status if the component is valid and in one of the modes. A null component gives Status::error
// without a log message.
template <class Body>
Status call(void* component, const char* function, unsigned modes, Body&& body) noexcept {
  auto* instance = static_cast<Instance*>(component);
  if (instance == nullptr) return Status::error;
  const FloatingPointGuard floating_point;
  const MemoryReserve memory;
  if (!allowed(*instance, function, modes)) return Status::error;
  try {
    const Status status = std::forward<Body>(body)(*instance);
    return status == Status::ok && memory.was_used() ? report_out_of_memory(*instance, function) : status;
  } catch (...) {
    return report_exception(*instance, function);
  }
}

// The same for functions of one kind of FMU.
template <class Body>
Status call(void* component, const char* function, Plant::Kind kind, unsigned modes, Body&& body) noexcept {
  auto* instance = static_cast<Instance*>(component);
  if (instance != nullptr && !is_of_kind(*instance, function, kind)) return Status::error;
  return call(component, function, modes, std::forward<Body>(body));
}

}  // namespace gelenk
