// SPDX-License-Identifier: BSD-3-Clause
// What a scene may say and hardly means: angles in degrees, two motors at a joint, a start beyond a stop.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/faults.h"
#include "scene/scene.h"

namespace gelenk {

// Of a scene that a program made or changed. Rotations are not looked at: they are matrices by now.
std::vector<std::string> find_doubts(const Scene& scene);

// Its parts. The scene must be valid.
void find_doubts(const Scene& scene, Faults& faults);
// An angle [rad] that was probably written in degrees.
void doubt_angle(double angle, const std::string& path, Faults& faults);

}  // namespace gelenk
