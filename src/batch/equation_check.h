// SPDX-License-Identifier: BSD-3-Clause
// Recorded equations compared with the kernels that simulations run.
#pragma once

#include <vector>

#include "equations/scene_equations.h"

namespace gelenk {

// Whether the recorded equations, with these values of the variables from VariedNumbers::first_variable on, are those
// of the scene: the same coordinates, inputs and constraints, and the same numbers at a state at which nothing
// vanishes. What has another form where a parameter changes, such as an exponent that is an integer or a coefficient
// that is 0, may have as many constants. Throws SingularMass.
bool are_equations_of(const TracedScene& scene, const SceneEquations& recorded, const std::vector<double>& numbers);

}  // namespace gelenk
