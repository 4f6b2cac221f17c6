// SPDX-License-Identifier: BSD-3-Clause
// Derivatives of a plant by value reference.
#pragma once

#include <span>

#include "fmu/runtime/plant.h"

namespace gelenk {

using References = std::span<const unsigned>;

// out[i] = sum over k of d unknown[i] / d known[k] * seed[k], at the present state and inputs. Unknowns: outputs and
// derivatives of states; knowns: inputs and states. Throws UsageError naming what is neither, NotDifferentiable.
void directional_derivative(Plant& plant, References unknown, References known, const double* seed, double* out);

// out[i]: time derivative of this order (1 to max_output_derivative_order) of an output, along the motion, with the
// inputs' own derivatives. Throws likewise.
void output_derivatives(Plant& plant, References outputs, const int* orders, double* out);

}  // namespace gelenk
