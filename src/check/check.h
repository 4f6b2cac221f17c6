// SPDX-License-Identifier: BSD-3-Clause
// Validation of a scene beyond the form of its fields: names, physical consistency, connection to the ground.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "scene/faults.h"
#include "scene/scene.h"

namespace gelenk {

// Names of joints and elements whose type or stop could not be read, so that missing parts of them are not reported.
using SuspectNames = std::set<std::string>;

// Checks a scene that a program created or changed by the rules for scene files. Throws SceneError with all errors.
void check_scene(const Scene& scene);

// Whether check_scene() finds no error, if it found none before numbers of bodies, joints or elements were changed.
bool numbers_are_valid(const Scene& scene);

// Adds all errors in a scene to `faults`. If that has errors from reading the file already, their consequences (empty
// names, masses that are NaN) are not reported again.
void find_faults(const Scene& scene, Faults& faults, const SuspectNames& suspect_names = {});

// The checks of find_faults(). partial: reading has reported errors, whose consequences are not reported again.
void check_names(const Scene& scene, Faults& faults);
void check_bodies(const Scene& scene, Faults& faults, bool partial);
// The shapes of bodies and of the ground.
void check_shapes(const Scene& scene, Faults& faults, bool partial);
void check_inertias(const Scene& scene, Faults& faults, bool partial);
void check_joints(const Scene& scene, Faults& faults, bool partial);
void check_connection(const Scene& scene, Faults& faults);
void check_elements(const Scene& scene, Faults& faults, bool partial);
// Motions that follow element states.
void check_motions(const Scene& scene, Faults& faults);
// Checks the fields of an element, each one and in combination.
template <class Any>
void check_numbers(const Element<Any>& element, const std::string& path, const Coordinate& coordinate, Faults& faults);
// Checks friction, limits and one-way clutches in combination with each other, with gears and with contacts.
void check_locking(const Scene& scene, Faults& faults);
// Checks the force of one kind along coordinate i of a joint; path: its own.
void check_force(const Joint& joint, std::size_t i, const std::string& path, const JointForceKind& kind,
                 Faults& faults);
void check_parameters(const Scene& scene, Faults& faults, const SuspectNames& suspect_names);
// partial: the available outputs are not known, so nothing is checked.
void check_outputs(const Scene& scene, Faults& faults, bool partial);

// Checks that the numbers of a frame are finite, its rotation is orthonormal and its body exists.
void check_frame(const BodyFrame& frame, const Scene& scene, const std::string& path, Faults& faults, bool partial);

// Adds an error for each of `size` numbers that is not finite; a single number is reported without an index.
void check_finite(const double* data, std::size_t size, const std::string& path, Faults& faults);

}  // namespace gelenk
