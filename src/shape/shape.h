// SPDX-License-Identifier: BSD-3-Clause
// The interface of shapes: solids from which masses, pictures and contacts are computed. S is the frame of the shape.
//
//   kind, summary        key in scene files, and what follows "a shape: ..."
//   fields()             the dimensions that are plain numbers or vectors (field/field.h)
//   bounded              whether the solid is finite. Shapes that are have:
//   mass_properties()    volume, center of mass and inertia for unit density, in S
//   support(d)           a point of the solid farthest in the direction d, both in S; d need not be a unit vector
//   size()               diameter of a sphere about the middle of the shape that contains it [m]; the length to which
//                        tolerances refer
//   fault()              error in dimensions that are each permitted; optional
//   drawn(extent)        what is drawn of it, extent [m]: of a piece of an unbounded solid; optional for bounded ones:
//                        without it, or if it is empty, the hull of points of support() is drawn
//   bounds(X_WS)         the smallest axis-aligned box in W that contains the solid at the pose X_WS
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "field/field.h"
#include "math/spatial.h"

namespace gelenk {

using Triangle = std::array<int, 3>;

// Of a solid with unit density: divided by the density they have the units of mass and inertia.
struct MassProperties {
  double volume = 0;                                  // m3
  Eigen::Vector3d center = Eigen::Vector3d::Zero();   // m
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // m5, about the center of mass
};

// What is drawn of a shape [m, in S]: balls, tubes with flat ends, and triangles between points, counterclockwise as
// seen from outside; without triangles the hull of the points.
struct Drawing {
  struct Ball {
    Eigen::Vector3d center;
    double radius;
  };
  struct Tube {
    Eigen::Vector3d from, to;
    double radius;
  };
  std::vector<Ball> balls{};
  std::vector<Tube> tubes{};
  std::vector<Eigen::Vector3d> points{};
  std::vector<Triangle> triangles{};
};

// Axis-aligned box. Sides at infinity belong to unbounded shapes.
struct Aabb {
  Eigen::Vector3d lower = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());
  Eigen::Vector3d upper = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());

  // The box enlarged by a margin on every side.
  Aabb grown(double margin) const { return {lower.array() - margin, upper.array() + margin}; }
  // Whether the boxes have a point in common.
  bool meets(const Aabb& b) const {
    return (lower.array() <= b.upper.array()).all() && (b.lower.array() <= upper.array()).all();
  }
};

}  // namespace gelenk
