// SPDX-License-Identifier: BSD-3-Clause
// Scenes whose numbers were rounded: the frames of joints in loops are moved, so that loops with redundant constraints
// close at every position (analysis/frame_adjustment.h).
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

// A joint's frame in one of its bodies, moved.
struct MovedFrame {
  std::string joint, body;
  double turn = 0;   // rad
  double shift = 0;  // in the scene's unit of length
};

struct AdjustedScene {
  Scene scene;
  std::vector<MovedFrame> moved;  // in the order of the file
  int degrees_of_freedom = 0;     // of the islands with loops
  bool closes = true;  // else no exact mechanism is near; scene: as it was, moved: what would be needed, if known
};

// scene: in natural units. tolerance: as AssemblySettings::tolerance.
AdjustedScene adjust(const Scene& scene, double tolerance);

// The least tolerance, a power of ten above `from` and up to `most`, that is enough; 0: none is. Loops that close with
// less and stand still then, because only one position was made to fit, get what makes them move, if it is not much
// more.
double sufficient_tolerance(const Scene& scene, double from, double most);

// What was moved, in a sentence; lengths in SI. Empty: nothing was.
std::string describe_moves(const Scene& scene, const std::vector<MovedFrame>& moved);

}  // namespace gelenk
