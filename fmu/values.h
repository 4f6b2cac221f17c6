// SPDX-License-Identifier: BSD-3-Clause
// Reading and setting values by value reference. Each function is one of FMI, in all versions, whose name is given for
// messages.
#pragma once

#include <cstddef>

#include "fmu/status.h"
#include "simulation/parameters.h"

namespace gelenk {

// The types of variables that a function accepts.
struct AcceptedTypes {
  ParameterType type, other;
};
inline constexpr AcceptedTypes reals{ParameterType::real, ParameterType::real};
inline constexpr AcceptedTypes booleans{ParameterType::boolean, ParameterType::boolean};
inline constexpr AcceptedTypes integers{ParameterType::integer, ParameterType::integer};
inline constexpr AcceptedTypes enumerations{ParameterType::enumeration, ParameterType::enumeration};
inline constexpr AcceptedTypes integers_and_enumerations{ParameterType::integer, ParameterType::enumeration};

// The variables of a call, and how many values it passes.
struct ValueCall {
  const char* function;
  AcceptedTypes types;
  const unsigned* references;
  std::size_t count, values;
};

template <class T>
Status get_values(void* instance, const ValueCall& of, T* values) noexcept;

// All values are checked before the first one is set, so that a call sets all of them or none.
template <class T>
Status set_values(void* instance, const ValueCall& of, const T* values) noexcept;

// Of inputs, in co-simulation.
Status set_input_derivatives(void* instance, const ValueCall& of, const int* orders, const double* values) noexcept;

// For types that no variable has, so that any reference is invalid.
Status refuse_type(void* instance, const char* function, const char* type, std::size_t count) noexcept;

}  // namespace gelenk
