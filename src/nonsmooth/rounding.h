// SPDX-License-Identifier: BSD-3-Clause
// What counts as rest, as contact and as a rebound, above the rounding of positions and velocities.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

namespace gelenk {

// Relative motions of shapes up to this are rest [natural units of speed]: what solvers leave of zero.
inline constexpr double rest_speed = 1e-9;

// The largest size of these velocities and of `least`: by what rounding of velocities is measured.
inline double fastest_of(std::span<const double> v, double least = 1) {
  for (const double speed : v) least = std::max(least, std::abs(speed));
  return least;
}

// A bound or a surface within this fraction of what counts as contact has been reached.
inline constexpr double reached_fraction = 1e-2;

// Up to what depth something that leaves is not in contact again: it may still be beyond its bound by rounding, at
// `depth`, and goes further by this fraction of what counts as contact.
inline double leaving_depth(double depth, double tolerance) {
  constexpr double leaving_fraction = 0.1;
  return std::max(0.0, depth) + leaving_fraction * tolerance;
}

// A series of impacts ends in contact when its rebounds are lower than this times what counts as contact: lower ones
// are lost in the rounding of the position. Their impulses would add up to that of the contact force.
inline constexpr double lowest_rebound = 2;

// Whether a rebound at this speed, with this acceleration back, rises no higher than `height`.
inline bool rises_no_higher(double height, double speed, double acceleration) {
  return acceleration > 0 && speed * speed <= 2 * acceleration * height;
}

// The fastest rebound of those.
inline double fastest_rebound(double height, double acceleration) { return std::sqrt(2 * acceleration * height); }

}  // namespace gelenk
