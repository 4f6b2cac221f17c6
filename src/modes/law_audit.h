// SPDX-License-Identifier: BSD-3-Clause
// Holds the forces that outputs show against the laws of friction, limits and contacts. It knows these laws only by
// their bounds, not how modes are decided, so that a wrong decision is found here.
#pragma once

#include <optional>
#include <span>

#include "dynamics/branching.h"

namespace gelenk {

struct BrokenLaw {
  enum class Kind {
    friction_exceeded,      // found: the friction; bound: what the law permits
    friction_along_motion,  // found: the friction; bound: the velocity
    limit_pulls,            // found: the force of the limit
    limit_not_reached,      // found: the force of the limit; bound: the distance from it
    limit_passed,           // bound: how far beyond it
    contact_pulls,          // found: the normal force
    contact_friction,       // found: the friction; bound: what the law permits
    contact_moment,         // found: the moment of friction; bound: what the law permits
  };
  Kind kind;
  int index;                    // of the force with modes; of the contact in the scene
  double found = 0, bound = 0;  // natural units, in the user's signs
};

// The first force along a joint that breaks its law. `branching`: at the state, with velocities v (nv) and with inputs
// set. forces: by force with modes, in the user's signs, as output.
std::optional<BrokenLaw> audit_locks(const Branching& branching, std::span<const double> forces, const double* v,
                                     int nv);

}  // namespace gelenk
