// SPDX-License-Identifier: BSD-3-Clause
// Warnings about valid but probably unintended contents of a scene: angles in degrees, lengths in millimeters, two
// motors at one joint, start values beyond a stop.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/faults.h"
#include "scene/scene.h"

namespace gelenk {

// Returns the warnings for a scene that a program created or changed. Rotations, which are matrices here, are not
// checked.
std::vector<std::string> find_warnings(const Scene& scene);

// Adds the warnings for a valid scene.
void find_warnings(const Scene& scene, Faults& faults);
// Adds a warning for each body whose center of mass or inertia does not fit the size of the mechanism.
void warn_about_sizes(const Scene& scene, Faults& faults);
// Adds a warning if an angle [rad] was probably given in degrees, or is too large to mean anything.
void warn_about_angle(double angle, const std::string& path, Faults& faults);

}  // namespace gelenk
