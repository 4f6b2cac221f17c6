// SPDX-License-Identifier: BSD-3-Clause
// A time near that of a scene's motion, for bounds on speeds and accelerations. Scenes themselves keep their times.
#pragma once

#include "scene/unit_system.h"

namespace gelenk {

// In s, a power of two: what falls by a length of these units under gravity takes it; without gravity, a vibration of
// the softest spring with a mass of these units; without springs, what the largest constant force pushes by a length. 1
// where that is between 1/16 and 16 s, and where nothing in a scene tells a time.
double natural_time(const Scene& scene, const UnitSystem& units);

}  // namespace gelenk
