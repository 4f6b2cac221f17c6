// SPDX-License-Identifier: BSD-3-Clause
// Messages about forces that break their laws, in the names of the scene and in SI units.
#pragma once

#include <string>

#include "kinematics/placed_formulas.h"
#include "mechanism/mechanism.h"
#include "nonsmooth/law_audit.h"
#include "scene/scene.h"

namespace gelenk {

struct Loads;

// The name of the element with the expression of this branch.
std::string owner_of_branch(const Scene& scene, const Mechanism& mechanism, const BranchPlace& place);

// A load that a contact shares with a joint; force: index of the joint's force with modes.
std::string describe_shared_load(const Scene& scene, const Loads& loads, int contact, int force);

std::string describe_broken_law(const Scene& scene, const Loads& loads, const BrokenLaw& broken);

}  // namespace gelenk
