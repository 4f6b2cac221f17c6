// SPDX-License-Identifier: BSD-3-Clause
// Which inputs and states each output and each state's derivative can depend on: ModelStructure of
// modelDescription.xml.
#pragma once

#include <set>
#include <vector>

#include "modelDescription/catalogue.h"
#include "simulation/simulation.h"

namespace gelenk {

// By variable of the catalogue, indices of inputs and states; of what is no output and no derivative: empty. Told from
// the structure: by parts without coupling, and by level (coordinates, speeds, accelerations), so a value listed may
// happen not to act, and one that is not listed cannot.
// simulation: assembled; the catalogue's states are declared.
std::vector<std::set<int>> dependencies_of(const Simulation& simulation, const Catalogue& catalogue);

// The same for values at the start: on inputs and parameters. What an output is computed with (solver.*) does not
// act on it there.
std::vector<std::set<int>> initial_dependencies_of(const Catalogue& catalogue,
                                                   const std::vector<std::set<int>>& dependencies);

}  // namespace gelenk
