// SPDX-License-Identifier: BSD-3-Clause
// Axes of joints that are parallel in their link up to a tolerance.
#pragma once

#include <vector>

#include "assembly/loop_geometry.h"

namespace gelenk {

// Turns the frames so that such axes are parallel, each group along its mean. Returns by frame whether it is in a
// group.
std::vector<bool> make_parallel(LoopGeometry& loops, double tolerance);

}  // namespace gelenk
