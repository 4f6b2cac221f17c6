// SPDX-License-Identifier: BSD-3-Clause
// What is probably not intended about the start of a mechanism: guesses that are changed a lot, one axis unlike the
// others.
#pragma once

#include <string>
#include <vector>

#include "assembly/assembly.h"
#include "dynamics/dynamics.h"
#include "mechanism/mechanism.h"

namespace gelenk {

// Adds warnings about the assembly that was found: if another one is equally near to the guesses, and about the guess
// that was changed most, if that is a lot; if parameters set start positions, among these only. `dynamics` must have
// been evaluated there.
void add_doubts(const Scene& scene, const ReducedScene& reduced, int island, const Assembled& found,
                const Dynamics& dynamics, std::vector<std::string>& warnings);

// Names the joint whose axis differs from those of all the others in a loop of at least four, which are parallel in the
// frames of the file; empty if there is none. In a planar linkage, that axis is a mistake.
std::string describe_odd_axis(const Scene& scene, const std::vector<int>& joints);

}  // namespace gelenk
