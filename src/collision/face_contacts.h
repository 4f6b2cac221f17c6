// SPDX-License-Identifier: BSD-3-Clause
// Contact points around the closest pair of points of two polyhedra.
#pragma once

#include "collision/contact_set.h"
#include "collision/solid.h"

namespace gelenk {

// Faces whose normal deviates less than this from the direction of contact touch as faces: cosine of 10 degrees. At
// larger angles their other corners are farther apart than any margin in use.
constexpr double facing = 0.985;

// Feature pairs whose gap is smaller than the distance of the bodies by more than this part of the size belong to other
// directions of contact.
constexpr double same_contact = 1e-9;

// Number of the pair of feature i of A and k of B.
inline int pair_feature(int i, int k, int count_B) {
  return static_cast<int>((static_cast<unsigned>(i) * static_cast<unsigned>(count_B) + static_cast<unsigned>(k)) &
                          0x7fffffffU);
}

// Finds the points by which polyhedra touch that are closest along n, at this distance: corners of one above a face of
// the other, and crossings of edges, each with the normal of its own pair of features.
void face_contacts(const Solid& A, const Solid& B, const Eigen::Vector3d& n, double distance, ContactSet& out);

}  // namespace gelenk
