// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "joint/kinds.h"

namespace gelenk {

// Whether the joint has the same pose after each full turn of coordinate i: not that of a screw.
bool repeats_each_turn(const AnyJoint& joint, int i);

}  // namespace gelenk
