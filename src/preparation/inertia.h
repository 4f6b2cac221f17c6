// SPDX-License-Identifier: BSD-3-Clause
// Links without inertia, and massless rods.
#pragma once

#include <vector>

#include "mechanism/mechanism.h"

namespace gelenk {

// These find massless rods that were reduced to distance constraints: a flag for each island, or in any island.
std::vector<bool> islands_with_rods(const ReducedScene& reduced);
bool has_rods(const ReducedScene& reduced);

// Gives all links unit inertias, for purely kinematic computations.
void give_inertia(Mechanism& mechanism);

// Returns true if the inertia of some link is singular up to round-off.
bool lacks_inertia(const Mechanism& mechanism);

}  // namespace gelenk
