// SPDX-License-Identifier: BSD-3-Clause
// Start values of the scene's joints, sorted into an island's order and signs, and back.
#pragma once

#include <vector>

#include "assembly/assembly.h"

namespace gelenk {

struct StartGuesses {
  InitialGuess tree, cuts;
};

StartGuesses start_guesses(const Scene& scene, const ReducedScene& reduced, int island);

// By speed of the tree: driven by a motor, or its start is fixed, or, of what rolls, a turn of a quaternion: a user
// would call it a state.
std::vector<bool> preferred_speeds(const Scene& scene, const ReducedScene& reduced, int island);

// The user's coordinates of a joint of the island at q, where `dynamics` stands; angles of a cut joint nearest to its
// start value.
std::vector<double> coordinates_of(const Scene& scene, const ReducedScene& reduced, int joint,
                                   const std::vector<double>& q, const Dynamics& dynamics);

// The same of its speeds at v, where `dynamics` moves so.
std::vector<double> velocities_of(const ReducedScene& reduced, int joint, const std::vector<double>& v,
                                  const Dynamics& dynamics);

}  // namespace gelenk
