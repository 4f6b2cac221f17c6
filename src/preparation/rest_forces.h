// SPDX-License-Identifier: BSD-3-Clause
// What dry friction, hard limits and contacts of shapes have to do to keep a mechanism at rest.
#pragma once

#include <string>
#include <vector>

#include "analysis/equilibrium.h"
#include "preparation/rest_contacts.h"
#include "scene/scene.h"

namespace gelenk {

struct RestForces {
  struct Of {
    std::string coordinate;  // "A.phi"
    std::string unit;        // of the forces below, along the coordinate
    double force = 0;        // of friction and contact together
    double limit = 0;        // of static friction; 0 without friction
    // Touches its upper (1) or its lower bound (-1), or none (0); or an engaged lock of the joint holds it.
    static constexpr int by_lock = 2;
    int side = 0;
  };
  std::vector<Of> coordinates{};  // all with friction, a limit or a lock, in SI units
  RestContacts contacts{};
  bool is_balanced = true;  // with these forces nothing accelerates
  bool is_held = true;      // friction and contact can exert them

  // Adds those of one of the mechanisms of the scene, in its units, at the closed position q and at rest. Where several
  // coordinates hold redundantly, the forces are distributed so that limits are used the least (linear/least_load.h).
  void add(const Scene& scene, const EquilibriumProblem& of, const std::vector<double>& q,
           const std::vector<double>& cut_q);
};

}  // namespace gelenk
