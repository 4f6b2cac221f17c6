// SPDX-License-Identifier: BSD-3-Clause
// What can be wrong with a scene beyond the form of its fields: names, physics, connection.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "scene/faults.h"
#include "scene/scene.h"

namespace gelenk {

// Names of joints and forces whose type, or stop, could not be read: nothing follows from what they lack.
using Doubtful = std::set<std::string>;

// Checks a scene that a program made or changed, by the rules for files. Throws SceneError.
void check_scene(const Scene& scene);

// Adds what check_scene throws. When reading has found faults already, what came of them (empty
// names, masses that are NaN) is passed over.
void find_faults(const Scene& scene, Faults& faults, const Doubtful& doubtful = {});

// Its parts.
void check_names(const Scene& scene, Faults& faults);
void check_bodies(const Scene& scene, Faults& faults, bool partial);
void check_inertias(const Scene& scene, Faults& faults, bool partial);
void check_joints(const Scene& scene, Faults& faults, bool partial);
void check_connection(const Scene& scene, Faults& faults);
void check_elements(const Scene& scene, Faults& faults, bool partial);
// The fields of an element, alone and together.
template <class Any>
void check_numbers(const Element<Any>& element, const std::string& path, const Coordinate& coordinate, Faults& faults);
// Likewise what a joint has of that kind.
void check_forces(const Joint& joint, const std::string& path, const JointForceKind& kind, Faults& faults);
void check_parameters(const Scene& scene, Faults& faults, const Doubtful& doubtful);
// partial: what outputs there are is not known.
void check_outputs(const Scene& scene, Faults& faults, bool partial);

// A frame whose numbers are finite and whose rotation is one, on a body there is.
void check_frame(const BodyFrame& frame, const Scene& scene, const std::string& path, Faults& faults, bool partial);

// Adds a fault if a number is not finite. size: how many numbers there are at data.
void check_finite(const double* data, std::size_t size, const std::string& path, Faults& faults);

}  // namespace gelenk
