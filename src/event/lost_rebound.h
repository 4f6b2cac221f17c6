// SPDX-License-Identifier: BSD-3-Clause
// The end of a series of impacts.
#pragma once

namespace gelenk {

// A series of impacts ends in contact when its rebounds are lower than this times what counts as contact: lower ones
// are lost in the rounding of the position. Their impulses would add up to that of the contact force.
inline constexpr double lowest_rebound = 2;

// Whether a rebound at this speed, with this acceleration back, rises no higher than `height`.
inline bool rises_no_higher(double height, double speed, double acceleration) {
  return acceleration > 0 && speed * speed <= 2 * acceleration * height;
}

}  // namespace gelenk
