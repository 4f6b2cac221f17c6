// SPDX-License-Identifier: BSD-3-Clause
// Characteristic time of a scene's motion, for bounds on velocities and accelerations. Scenes are not scaled in time.
#pragma once

#include "scene/unit_system.h"

namespace gelenk {

// Returns a characteristic time [s], a power of two, with the unit length L and unit mass m of `units`: sqrt(L/g) under
// gravity g; without gravity, sqrt(m/k) with the smallest spring stiffness k; without springs, sqrt(m L/F) with the
// largest constant force F. Returns 1 if that time is between 1/16 and 16 s or if the scene has none of these.
double natural_time(const Scene& scene, const UnitSystem& units);

}  // namespace gelenk
