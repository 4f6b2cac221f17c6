// SPDX-License-Identifier: BSD-3-Clause
// Points at which two shapes touch or are about to.
#pragma once

#include <Eigen/Core>

#include "math/spatial.h"
#include "shape/registry.h"

namespace gelenk {

// A point of contact between shapes A and B.
struct ContactPoint {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();        // in W [m]: middle between both surfaces
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // in W: unit vector, from A to B
  double gap = 0;                                     // m, along the normal; negative: penetration
  int feature = 0;  // number of the pair of features (corner, edge, face, ...); the same while these touch
};

constexpr int max_contact_points = 4;

// Finds the contact points with a gap up to the margin [m]; returns their number, 0 to max_contact_points. out[0] is
// the closest or deepest pair of points of the two solids, the others are further points that support both, as on two
// faces. Features are in ascending order from out[1] on.
//
// The gap of a feature pair is a smooth function of the poses, and its rate is normal . (v_B(p) - v_A(p)), with the
// velocities of the points of both bodies at p. Never allocates; same arguments, same bits; exchanging A and B reverses
// the normals and keeps everything else.
int find_contacts(const AnyShape& A, const Pose3& X_WA, const AnyShape& B, const Pose3& X_WB, double margin,
                  ContactPoint* out);

}  // namespace gelenk
