// SPDX-License-Identifier: BSD-3-Clause
// Geometry of edges that cross and of rims above planes, in the root frame.
#pragma once

#include <algorithm>

#include "contact_geometry/contact_candidates.h"

namespace gelenk {

// Edges with a smaller sine of the angle between them count as parallel.
inline constexpr double least_sine = 1e-4;
// A cylinder whose axis has a smaller sine of the angle to the normal of a plane is on its flat end.
inline constexpr double flat_sine = 1e-3;
// Beyond the ends of features by less than this, shapes still touch there [natural units of length].
inline constexpr double near_tolerance = 1e-10;

// The points of two lines next to each other.
struct ContactCandidates::Crossing {
  Eigen::Vector3d a, b;      // directions, of the tip and the core
  Eigen::Vector3d d;         // from the center of the core's edge to that of the tip's
  Eigen::Vector3d c, n;      // a x b; unit normal, from the core to the tip
  Eigen::Vector3d p_a, p_b;  // m
  double s = 0, t = 0;       // m, along the edges from their centers
  double sine = 0;           // of the angle between them
  double sign = 1;           // of n relative to c
  double gap = 0;            // m
  double left = 0;           // m, to the nearest end of an edge; negative beyond it
  double margin() const { return std::min(left, sine - least_sine); }
  bool is_outside = false;  // n points out of the core, and -n out of the tip
};

// The point of a rim that is lowest above a plane.
struct ContactCandidates::Lowest {
  Eigen::Vector3d n, axis, c;  // normal, unit axis, center of the rim
  Eigen::Vector3d e;           // unit, from the lowest point to the center
  double sine = 0;             // of the angle between n and the axis
  double gap = 0;              // m
};

}  // namespace gelenk
