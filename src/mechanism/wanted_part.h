// SPDX-License-Identifier: BSD-3-Clause
// A scene without what none of its wanted outputs depends on.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

struct WantedPart {
  Scene scene;
  // What was left out: how many islands, and the names of what was in them or stood still.
  int islands = 0;
  std::vector<std::string> bodies, joints;

  // "left out, since no wanted output depends on it: 2 islands (bodies a, b; joints A, B)"; empty where nothing is.
  std::string report() const;
};

// The islands that a wanted output comes from, with all that acts on them, and sensors with a wanted output; the scene
// itself where it lists no outputs, wants the energy of all, or where the reductions `outputs` or `islands` are off.
// Each island is to the bit what it is in the whole. Throws SceneError for welds that contradict each other.
WantedPart wanted_part(const Scene& scene);

}  // namespace gelenk
