// SPDX-License-Identifier: BSD-3-Clause
// Start values of the scene's joints, sorted into the mechanism's order and signs.
#pragma once

#include <vector>

#include "analysis/assembly.h"

namespace gelenk {

struct StartWishes {
  Wishes tree, cuts;
};

StartWishes start_wishes(const Scene& scene, const Mechanism& mechanism);

// By speed of the tree: driven by a motor, or its start is fixed: a user would call it a state.
std::vector<bool> preferred_speeds(const Scene& scene, const Mechanism& mechanism);

}  // namespace gelenk
