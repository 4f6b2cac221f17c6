// SPDX-License-Identifier: BSD-3-Clause
// Dependencies of outputs and state derivatives on inputs and states, for ModelStructure in modelDescription.xml.
#pragma once

#include <memory>
#include <vector>

#include "modelDescription/catalog.h"
#include "simulation/simulation.h"

namespace gelenk {

// Indices of variables, ascending. Variables with equal dependencies share a list, as most variables of an island do.
using Knowns = std::shared_ptr<const std::vector<int>>;

// For each variable of the catalog, the inputs and states on which it can depend; empty for variables that are neither
// outputs nor derivatives. Determined from the structure (islands and levels: coordinates, velocities, accelerations),
// so that a listed value may have no effect, but one that is not listed cannot have any.
// simulation: assembled; the states of the catalog must have been declared.
std::vector<Knowns> dependencies_of(const Simulation& simulation, const Catalog& catalog);

// The same for initial values, which depend on inputs and parameters. Settings of methods (solver.*) do not affect
// them, except solver.start.
std::vector<Knowns> initial_dependencies_of(const Catalog& catalog, const std::vector<Knowns>& dependencies);

}  // namespace gelenk
