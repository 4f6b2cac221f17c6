// SPDX-License-Identifier: BSD-3-Clause
// Edges and rims of shapes, which touch where corners do not.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "shape/kinds.h"

namespace gelenk {

// A straight edge of a solid, or the axis of a round one.
struct SolidEdge {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();      // m
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();  // unit
  double half = 0;                                       // m
  double radius = 0;                                     // m, about it; 0: it is sharp
  std::array<Eigen::Vector3d, 2> normals;                // of the faces at a sharp edge

  bool is_sharp() const { return radius == 0; }
};

// A circular edge of a cylinder, or the ring within the crown of a wheel.
struct SolidRim {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  // m
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();   // unit
  double radius = 0;                                 // m
  double crown = 0;                                  // m, about the ring
};

// None for shapes that have none.
std::vector<SolidEdge> edges_of(const AnyShape& shape);
std::vector<SolidRim> rims_of(const AnyShape& shape);

// Whether all contacts of the two shapes are those of corners, faces and edges.
bool edges_touch(const AnyShape& a, const AnyShape& b);
// Whether they are those of the rims of the first with the plane of the second.
bool rims_touch_plane(const AnyShape& of_rims, const AnyShape& plane);

}  // namespace gelenk
