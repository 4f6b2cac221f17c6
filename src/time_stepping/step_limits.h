// SPDX-License-Identifier: BSD-3-Clause
// Numbers that the parts of a time-stepping scheme share.
#pragma once

#include "nonsmooth/rounding.h"

namespace gelenk {

// Changes of velocities by forces that are evaluated again do not count up to this part of the largest velocity, or of
// 1e-3 [natural units of speed].
inline constexpr double negligible_change = 1e-11;
inline constexpr double residual_floor = 1e-3;

// Velocities that solutions leave where points stick or latches hold, in units of the residual that users permit: they
// add up over steps in which it is not exceeded.
inline constexpr double left_tolerances = 10;

// Of a cone problem.
inline constexpr int most_cone_iterations = 200;
// Velocities that solutions miss, relative to the largest, beyond which they are none.
inline constexpr double impossible_fraction = 1e-3;

// A step is divided into halves, and these again, up to this number of times.
inline constexpr int most_halvings = 4;

}  // namespace gelenk
