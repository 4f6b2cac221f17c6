// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kinematics/loads.h"
#include "recorded/recorded_algebra.h"

namespace gelenk::kernels {

// The forces between bodies, by their index in the scene, that have hidden branches. After velocities.
template <class A>
std::vector<int> hidden_branches(const Loads& loads, const Recorded* u, Workspace<A>& ws);

}  // namespace gelenk::kernels
