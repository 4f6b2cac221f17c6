// SPDX-License-Identifier: BSD-3-Clause
// Which inputs and states each output and each state's derivative can depend on: ModelStructure of
// modelDescription.xml.
#pragma once

#include <memory>
#include <vector>

#include "modelDescription/catalog.h"
#include "simulation/simulation.h"

namespace gelenk {

// Indices of variables, ascending. Variables that depend on the same share a list: most of a large part do.
using Knowns = std::shared_ptr<const std::vector<int>>;

// By variable of the catalogue, inputs and states; of what is no output and no derivative: an empty list. Told from
// the structure: by parts without coupling, and by level (coordinates, speeds, accelerations), so a value listed may
// happen not to act, and one that is not listed cannot.
// simulation: assembled; the catalogue's states are declared.
std::vector<Knowns> dependencies_of(const Simulation& simulation, const Catalog& catalog);

// The same for values at the start: on inputs and parameters. What an output is computed with (solver.*) does not
// act on it there.
std::vector<Knowns> initial_dependencies_of(const Catalog& catalog, const std::vector<Knowns>& dependencies);

}  // namespace gelenk
