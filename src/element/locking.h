// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

#include "element/constraints/mesh_losses.h"
#include "element/kinds.h"

namespace gelenk {

// The group of the element that can keep the coordinate at rest, with a force that the equations of motion determine:
// dry friction, a hard limit, a one-way clutch or a lock; empty if there is none.
std::string_view locking_element(const JointForces& forces);

// Whether there is friction to which losses of meshes can be added.
bool takes_loads(const JointForces& forces);
// Whether the friction depends on the force that a bearing or guide transmits.
bool has_bearing(const JointForces& forces);
// Whether the friction depends on the force across a guide.
bool is_loaded_guide(const JointForces& forces);
// Which of its joints has the friction by which a constraint loses power; -1: it loses none.
int lossy_joint(const AnyConstraint& constraint);
// These losses; none if it loses none.
MeshLosses losses_of(const AnyConstraint& constraint);

void erase_friction(JointForces& forces);
// Removes the elements that can keep the coordinate at rest.
void erase_locking_elements(JointForces& forces);

}  // namespace gelenk
