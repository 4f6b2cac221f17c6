// SPDX-License-Identifier: BSD-3-Clause
// Convex polyhedra as the hull of a set of points, and mass properties of solids bounded by triangles.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "shape/shape.h"

namespace gelenk {

// A convex polyhedron. Faces are polygons; vertices are those of the given points that are corners, in their order.
struct Polyhedron {
  // A flat face with the outer unit normal n and n.x = offset on its plane; its vertices, counterclockwise as seen from
  // outside, are loops[first] to loops[first + count - 1].
  struct Face {
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    double offset = 0;
    int first = 0;
    int count = 0;
  };
  // An edge between two vertices; face[0] has it from vertex[0] to vertex[1], face[1] in the opposite direction.
  struct Edge {
    std::array<int, 2> vertex{}, face{};
  };

  std::vector<Eigen::Vector3d> vertices;
  std::vector<Face> faces;
  std::vector<int> loops;
  std::vector<int> loop_edges;  // number of the edge from loops[i] to its successor
  std::vector<Edge> edges;
  std::vector<int> neighbors;  // adjacent vertices of vertex i: neighbors[first_neighbor[i]] to [first_neighbor[i + 1]]
  std::vector<int> first_neighbor;

  std::span<const int> loop(std::size_t face) const {
    return std::span(loops).subspan(static_cast<std::size_t>(faces[face].first),
                                    static_cast<std::size_t>(faces[face].count));
  }
  // Vertex farthest in the direction d.
  int farthest(const Eigen::Vector3d& d) const;
};

// Returns the convex hull of the points. Points closer to a plane than 1e-7 of the extent of all points, the rounding
// error of coordinates in single precision, are in that plane, so that the triangles of a flat side form one face.
// Throws std::invalid_argument with a sentence if there are fewer than 4 points, if they lie in a plane, if one is not
// finite.
Polyhedron convex_hull(std::span<const Eigen::Vector3d> points);

// Triangles of its faces between its vertices.
std::vector<Triangle> triangles_of(const Polyhedron& solid);

// Returns the mass properties of the solid within a closed surface of triangles, exact to within rounding errors
// (integration over tetrahedra). Throws std::invalid_argument with a sentence if the surface is not closed or its
// triangles are not all counterclockwise as seen from outside.
MassProperties mass_properties_of_mesh(std::span<const Eigen::Vector3d> vertices, std::span<const Triangle> triangles);

// The same for a closed surface that is known to be valid.
MassProperties integrate_over_mesh(std::span<const Eigen::Vector3d> vertices, std::span<const Triangle> triangles);

}  // namespace gelenk
