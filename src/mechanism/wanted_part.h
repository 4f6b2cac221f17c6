// SPDX-License-Identifier: BSD-3-Clause
// Omission of the islands on which no requested output depends.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

struct WantedPart {
  Scene scene;
  // The omitted parts: number of islands, and names of their bodies and joints and of immobile ones.
  int islands = 0;
  std::vector<std::string> bodies, joints;

  // "omitted, because no requested output depends on it: 2 islands (bodies a, b; joints A, B)"; empty if nothing is
  // omitted.
  std::string report() const;
};

// The islands with a requested output, with all elements that act on them, and the sensors with a requested output; the
// scene itself if it lists no outputs, if the total energy is requested, or if the reduction `outputs` or `islands` is
// off. Each island is bit for bit the same as in the whole scene. Throws SceneError for welds that contradict each
// other.
WantedPart wanted_part(const Scene& scene);

}  // namespace gelenk
