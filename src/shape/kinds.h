// SPDX-License-Identifier: BSD-3-Clause
// Shapes of all kinds, for code that does not depend on particular kinds: these are in registry.h.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "shape/shape.h"
#include "util/stored.h"

namespace gelenk {

struct AnyShape;  // a shape of any kind
extern template class Stored<AnyShape>;

// Description of a kind of shape for code that does not depend on particular shapes.
struct ShapeKind {
  std::string_view kind, summary;
  std::span<const Field> fields;  // none for a plane and for what consists of points
  bool bounded = true;            // whether it has mass properties and a finite size
  bool of_points = false;         // whether it is made from a list of points: make_shape_of_points()
  bool of_triangles = false;      // whether triangles between these points are its surface
  std::optional<ElementFault> (*fault)(const void* shape) = nullptr;  // in dimensions that are each permitted
};

// All kinds, in the order of AnyShape.
std::span<const ShapeKind> shape_kinds();
// Returns the kind of this name, or nullptr.
const ShapeKind* find_shape_kind(std::string_view name);
const ShapeKind& kind_of(const AnyShape& shape);

// Makes a shape of the n-th kind with default dimensions. Throws std::out_of_range if there is no such kind.
Stored<AnyShape> make_shape(std::size_t n);
// Makes a shape of the n-th kind, which must be of_points; triangles are those of a shape of_triangles. Throws
// std::invalid_argument with a sentence if the points span no volume, or the triangles do not enclose one.
Stored<AnyShape> make_shape_of_points(std::size_t n, std::vector<Eigen::Vector3d> points,
                                      std::vector<Triangle> triangles = {});
// Points from which a shape was made; empty unless its kind is of_points.
std::span<const Eigen::Vector3d> points_of(const AnyShape& shape);
// The triangles of its surface; empty unless its kind is of_triangles.
std::span<const Triangle> triangles_of(const AnyShape& shape);

// Address of the shape in the variant, to which its fields refer.
void* data_of(AnyShape& shape);
const void* data_of(const AnyShape& shape);

// Mass properties for unit density, in the frame of the shape; none for an unbounded shape.
std::optional<MassProperties> mass_properties(const AnyShape& shape);
// Point farthest in the direction d, both in the frame of the shape; none for an unbounded shape.
std::optional<Eigen::Vector3d> support(const AnyShape& shape, const Eigen::Vector3d& d);
// Diameter of a sphere that contains the shape [m]; infinite for an unbounded shape.
double size_of(const AnyShape& shape);
// What is drawn of the shape, with triangles; extent [m]: of a piece of an unbounded shape.
Drawing drawing_of(const AnyShape& shape, double extent);
// Smallest axis-aligned box in W that contains the shape.
Aabb bounds(const AnyShape& shape, const Pose3& X_WS);

}  // namespace gelenk
