// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "dynamics/dynamics.h"
#include "preparation/preparation.h"
#include "scene/scene.h"

namespace gelenk {

// Throws SceneError if friction depends on a force that redundant constraint equations of the island leave
// undetermined.
void check_loads_of_friction(const Scene& scene, const Loads& loads, const Mechanism& mechanism,
                             const PreparedIsland& island, Dynamics& dynamics);

}  // namespace gelenk
