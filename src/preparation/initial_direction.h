// SPDX-License-Identifier: BSD-3-Clause
// The direction in which an island sets out.
#pragma once

#include <vector>

#include "assembly/assembly.h"
#include "dynamics/dynamics.h"
#include "formulation/inputs.h"

namespace gelenk {

// The signals of a scene with this number of element states at `time` [s], all inputs and states zero.
std::vector<double> without_inputs(const Inputs& inputs, std::size_t states, double time);

// The velocities of an island at its start or, at rest, its accelerations under the signals u; empty: it does not move.
std::vector<double> initial_direction(const Assembled& start, Dynamics& of, const double* u);

}  // namespace gelenk
