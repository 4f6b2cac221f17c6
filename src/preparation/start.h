// SPDX-License-Identifier: BSD-3-Clause
// Conversion of start values between the joints of a scene and the order and signs of an island.
#pragma once

#include <vector>

#include "assembly/assembly.h"
#include "formulation/inputs.h"
#include "mechanism/mechanism.h"
#include "scene/scene.h"

namespace gelenk {

struct StartGuesses {
  InitialGuess tree, cuts;
};

// Returns the start values, fixed or guesses, of the tree joints and cut joints of an island.
StartGuesses start_guesses(const Scene& scene, const ReducedScene& reduced, int island);

// Returns a flag for each velocity of the tree that is preferred as an independent one: its joint is driven by a motor,
// or its start value is fixed, or it belongs to a quaternion in an island with rolling contacts.
std::vector<bool> preferred_velocities(const Scene& scene, const ReducedScene& reduced, int island);

// Returns a joint's coordinates, in the signs of the scene, at q, at which `dynamics` must have been evaluated. Angles
// of cut joints are those nearest to their start values.
std::vector<double> coordinates_of(const Scene& scene, const ReducedScene& reduced, int joint,
                                   const std::vector<double>& q, const Dynamics& dynamics);

// Returns a joint's velocities, in the signs of the scene, at v, at which `dynamics` must have been evaluated.
std::vector<double> velocities_of(const ReducedScene& reduced, int joint, const std::vector<double>& v,
                                  const Dynamics& dynamics);

// The start values of the element states of an island, in natural units.
std::vector<double> states_at_start(const Scene& scene, const Mechanism& mechanism);

// These, after the signals that inputs are: those that motions may follow.
std::vector<double> signals_at_start(const Scene& scene, const Mechanism& mechanism, const Inputs& inputs);

// Throws SceneError if a prescribed motion of the island has no finite value, speed or acceleration at `time`, as
// log(t) at 0.
void check_prescribed_motions(const Scene& scene, const Mechanism& mechanism, double time);
// Throws SceneError for a relation of coordinates that has no finite value or no gradient at this position.
void check_relations(const Scene& scene, const Mechanism& mechanism, const std::vector<double>& q);

}  // namespace gelenk
