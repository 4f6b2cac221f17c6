// SPDX-License-Identifier: BSD-3-Clause
// Adjustment of scenes with rounded dimensions: frames of joints in loops are moved so that loops with redundant
// constraints close at every position (assembly/frame_adjustment.h).
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

// A joint frame that was moved, in one of the two bodies of the joint.
struct MovedFrame {
  std::string joint, body;
  double turn = 0;   // rotation [rad]
  double shift = 0;  // translation, in the scene's unit of length
};

struct AdjustedScene {
  Scene scene;
  std::vector<MovedFrame> moved;  // in the order of the file
  int degrees_of_freedom = 0;     // total of the islands with loops
  bool closes = true;  // if false: `scene` is unchanged, and `moved` are the moves that would be needed, if known
};

// Adjusts the joint frames of a scene in natural units. tolerance: as AssemblySettings::tolerance.
AdjustedScene adjust(const Scene& scene, double tolerance);

// Returns the smallest sufficient tolerance, a power of ten above `from` and up to `max_tolerance`; 0 if there is none.
// If loops close with it at one position only, so that they cannot move, a larger tolerance at which they can move is
// returned, provided that it is at most 100 times as large.
double sufficient_tolerance(const Scene& scene, double from, double max_tolerance);

// Returns a sentence about the moved frames, with lengths in SI units; empty if none was moved.
std::string describe_moves(const Scene& scene, const std::vector<MovedFrame>& moved);

}  // namespace gelenk
