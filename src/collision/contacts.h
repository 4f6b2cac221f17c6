// SPDX-License-Identifier: BSD-3-Clause
// Points at which two shapes touch or are about to.
#pragma once

#include <Eigen/Core>

#include "math/spatial.h"
#include "shape/kinds.h"

namespace gelenk {

// A point of contact between shapes A and B.
struct ContactPoint {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();        // in W [m]: middle between both surfaces
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // in W: unit vector, from A to B
  double gap = 0;                                     // m, along the normal; negative: penetration
  int feature = 0;  // number of the pair of features (corner, edge, face, ...); the same while these touch
};

constexpr int max_contact_points = 4;

// Finds contact points with a gap up to the margin [m], in ascending order of their features; returns their number, 0
// to max_contact_points. The smallest gap is the distance of the two solids or, if they overlap, the negative of the
// shortest translation that separates them. Shapes that touch along an edge or face have several points.
//
// The gap of a feature pair is a smooth function of the poses, and its rate is normal . (v_B(p) - v_A(p)), with the
// velocities at p of both bodies. Nothing is allocated; same arguments, same bits. If the shapes are of different
// kinds, exchanging them reverses the normals and changes nothing else. Two half-spaces have no contact points.
int find_contacts(const AnyShape& A, const Pose3& X_WA, const AnyShape& B, const Pose3& X_WB, double margin,
                  ContactPoint* out);

}  // namespace gelenk
