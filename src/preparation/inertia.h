// SPDX-License-Identifier: BSD-3-Clause
// Parts of a mechanism that move without inertia.
#pragma once

#include <vector>

#include "mechanism/mechanism.h"

namespace gelenk {

// Rods without mass that became rows: by island, and in any.
std::vector<bool> islands_with_rods(const ReducedScene& reduced);
bool has_rods(const ReducedScene& reduced);

// For what is only kinematics: nothing in it moves without inertia.
void give_inertia(Mechanism& mechanism);

// Some link has no inertia, but for rounding, along a motion of its own.
bool lacks_inertia(const Mechanism& mechanism);

}  // namespace gelenk
