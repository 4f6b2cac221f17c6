// SPDX-License-Identifier: BSD-3-Clause
// The pivots of a scene's equations.
#pragma once

#include <vector>

#include "equations/scene_equations.h"
#include "recorded/pivots.h"

namespace gelenk {

struct PivotsOfScene : Pivots {
  std::vector<double> q, u;  // where they have their usual size
};

// Of the largest size at the start, if it is a regular position, otherwise nearby.
PivotsOfScene pivots_of(const TracedScene& scene);

}  // namespace gelenk
