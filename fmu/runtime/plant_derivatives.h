// SPDX-License-Identifier: BSD-3-Clause
// Derivatives of a plant by value reference.
#pragma once

#include <span>

#include "fmu/runtime/plant.h"

namespace gelenk {

using References = std::span<const unsigned>;

// Numbers with the name of the argument of FMI, for messages.
struct NamedSeed {
  const char* name;
  const double* values;
};

// out[i] = sum over k of d unknown[i] / d known[k] * seed[k], at the present state and inputs. Unknowns: outputs and
// derivatives of states; knowns: inputs and states. Throws UsageError for other variables, and NotDifferentiable.
void directional_derivative(Plant& plant, References unknown, References known, NamedSeed seed, double* out);

// out[k] = sum over i of seed[i] * d unknown[i] / d known[k]: the transpose of the same matrix.
void adjoint_derivative(Plant& plant, References unknown, References known, NamedSeed seed, double* out);

// out[i]: time derivative of order orders[i] (1 to max_output_derivative_order) of outputs[i] along the motion,
// including the time derivatives of the inputs. Throws UsageError for other variables or orders, and NotDifferentiable.
void output_derivatives(Plant& plant, References outputs, const int* orders, double* out);

}  // namespace gelenk
