// SPDX-License-Identifier: BSD-3-Clause
// What dry friction and hard limits have to do to keep a simulation at rest at its present position.
#pragma once

#include <string>
#include <vector>

#include "simulation/simulation.h"

namespace gelenk {

struct RestForces {
  struct Of {
    std::string coordinate;  // "A.phi"
    std::string unit;        // of the forces below, along the coordinate
    double force = 0;        // of friction and contact together
    double limit = 0;        // of static friction; 0 without friction
    int side = 0;            // touches its upper (1) or its lower bound (-1), or none (0)
  };
  std::vector<Of> coordinates;  // all with friction or a limit, in SI units
  bool is_balanced = false;     // with these forces nothing would accelerate
  bool is_held = false;         // friction and contact can exert them
};

// With the present inputs, at zero velocity. Requires initialize() or assemble(); does not change the run.
RestForces find_rest_forces(Simulation& of);

}  // namespace gelenk
