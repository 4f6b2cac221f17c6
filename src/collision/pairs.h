// SPDX-License-Identifier: BSD-3-Clause
// The routines behind find_contacts(), each for pairs of certain shapes A and B in the order of AnyShape. Poses are
// relative to a point near both shapes, so that no digits are lost far from the origin of W.
#pragma once

#include "collision/contact_set.h"
#include "shape/registry.h"

namespace gelenk {

// Half-spaces: X_P is the pose of the plane; normals point from the half-space to the shape.
void plane_contacts(const Pose3& X_P, const Sphere& B, const Pose3& X_B, ContactSet& out);
void plane_contacts(const Pose3& X_P, const Capsule& B, const Pose3& X_B, ContactSet& out);
void plane_contacts(const Pose3& X_P, const Box& B, const Pose3& X_B, ContactSet& out);
void plane_contacts(const Pose3& X_P, const Cylinder& B, const Pose3& X_B, ContactSet& out);
void plane_contacts(const Pose3& X_P, const Wheel& B, const Pose3& X_B, ContactSet& out);
void plane_contacts(const Pose3& X_P, const Hull& B, const Pose3& X_B, ContactSet& out);
inline void plane_contacts(const Pose3& X_P, const Mesh& B, const Pose3& X_B, ContactSet& out) {
  plane_contacts(X_P, B.hull(), X_B, out);
}

void contacts(const Sphere& A, const Pose3& X_A, const Sphere& B, const Pose3& X_B, ContactSet& out);
void contacts(const Sphere& A, const Pose3& X_A, const Capsule& B, const Pose3& X_B, ContactSet& out);
void contacts(const Sphere& A, const Pose3& X_A, const Box& B, const Pose3& X_B, ContactSet& out);
void contacts(const Sphere& A, const Pose3& X_A, const Cylinder& B, const Pose3& X_B, ContactSet& out);
void contacts(const Capsule& A, const Pose3& X_A, const Capsule& B, const Pose3& X_B, ContactSet& out);
void contacts(const Box& A, const Pose3& X_A, const Box& B, const Pose3& X_B, ContactSet& out);

// All other pairs of bounded shapes.
void convex_contacts(const AnyShape& A, const Pose3& X_A, const AnyShape& B, const Pose3& X_B, ContactSet& out);

}  // namespace gelenk
