// SPDX-License-Identifier: BSD-3-Clause
// Derivatives of outputs and states with respect to states, inputs and time. Each function is one of FMI, in all
// versions, whose name is given for messages.
#pragma once

#include <cstddef>

#include "fmu/status.h"

namespace gelenk {

// An argument that is a list of numbers.
template <class T>
struct ListArgument {
  const char* name;
  T* values;
  std::size_t count;
};
using ReferenceList = ListArgument<const unsigned>;
using Seed = ListArgument<const double>;
using Sensitivities = ListArgument<double>;

// seed: by known, result: by unknown.
Status get_directional_derivative(void* instance, const char* function, const ReferenceList& unknowns,
                                  const ReferenceList& knowns, const Seed& seed, const Sensitivities& out) noexcept;

// seed: by unknown, result: by known.
Status get_adjoint_derivative(void* instance, const char* function, const ReferenceList& unknowns,
                              const ReferenceList& knowns, const Seed& seed, const Sensitivities& out) noexcept;

// A function of co-simulation. FMI permits this call only after steps; Maestro also makes it in initialization mode,
// where the values are known, too.
Status get_output_derivatives(void* instance, const char* function, const ReferenceList& outputs, const int* orders,
                              const Sensitivities& out) noexcept;

}  // namespace gelenk
