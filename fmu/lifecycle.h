// SPDX-License-Identifier: BSD-3-Clause
// Creation of instances, and changes of their mode. Each function is one of FMI, in all versions, whose name is given
// for messages.
#pragma once

#include <cstddef>
#include <optional>

#include "fmu/log.h"
#include "fmu/runtime/plant.h"
#include "fmu/status.h"

namespace gelenk {

struct Instantiation {
  const char* function;
  Interface interface;
  Plant::Kind kind;
  const char *token, *resources;
  std::string fault{};  // what the version of FMI refuses; empty: nothing
};

// Returns null, after a message, if the instance cannot be created.
void* instantiate(const Log& log, const Instantiation& wanted) noexcept;
void free_instance(void* instance) noexcept;

Status set_debug_logging(void* instance, const char* function, bool on, std::size_t count,
                         const char* const categories[]) noexcept;

struct ExperimentSetup {
  std::optional<double> tolerance;
  double start;
  std::optional<double> stop;
};
// Returns the value unless it is not defined.
inline std::optional<double> given(bool defined, double value) { return defined ? std::optional(value) : std::nullopt; }

Status setup_experiment(void* instance, const char* function, const ExperimentSetup& experiment) noexcept;
// experiment: null if another function received it.
Status enter_initialization(void* instance, const char* function, const ExperimentSetup* experiment) noexcept;
Status exit_initialization(void* instance, const char* function) noexcept;
Status terminate(void* instance, const char* function) noexcept;
Status reset(void* instance, const char* function) noexcept;

}  // namespace gelenk
