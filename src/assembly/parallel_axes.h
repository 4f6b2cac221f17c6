// SPDX-License-Identifier: BSD-3-Clause
// Joint axes of a link that are parallel up to a tolerance.
#pragma once

#include <vector>

#include "assembly/loop_geometry.h"

namespace gelenk {

// Turns the frames so that such axes become exactly parallel to the mean of their group. tolerance [rad]. Returns for
// each frame whether it belongs to a group.
std::vector<bool> make_parallel(LoopGeometry& loops, double tolerance);

}  // namespace gelenk
