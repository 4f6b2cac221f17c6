// SPDX-License-Identifier: BSD-3-Clause
#include "shapes.h"

#include <nanobind/stl/tuple.h>

#include <tuple>

#include "shape/polyhedron.h"

namespace nb = nanobind;

namespace native {
namespace {

using Mass = std::tuple<double, Numbers, Table>;

Mass listed(const gelenk::MassProperties& of) {
  Table inertia;
  for (int i = 0; i < 3; ++i) inertia.push_back(numbers(of.inertia.row(i)));
  return {of.volume, numbers(of.center), inertia};
}

std::pair<Numbers, Numbers> listed(const gelenk::Aabb& of) { return {numbers(of.lower), numbers(of.upper)}; }

std::optional<Mass> mass_of(const gelenk::AnyShape& of) {
  const auto found = gelenk::mass_properties(of);
  return found ? std::optional(listed(*found)) : std::nullopt;
}

std::optional<Numbers> support_of(const gelenk::AnyShape& of, const Numbers& d) {
  const auto found = gelenk::support(of, vector3(d));
  return found ? std::optional(numbers(*found)) : std::nullopt;
}

// Vertices, faces as lists of vertices, edges as pairs of vertices.
std::tuple<Table, std::vector<std::vector<int>>, std::vector<std::pair<int, int>>> hull(const Table& points) {
  const gelenk::Polyhedron solid = gelenk::convex_hull(points3(points));
  Table vertices;
  for (const Eigen::Vector3d& v : solid.vertices) vertices.push_back(numbers(v));
  std::vector<std::vector<int>> faces;
  for (std::size_t f = 0; f < solid.faces.size(); ++f) faces.emplace_back(solid.loop(f).begin(), solid.loop(f).end());
  std::vector<std::pair<int, int>> edges;
  for (const auto& edge : solid.edges) edges.emplace_back(edge.vertex[0], edge.vertex[1]);
  return {vertices, faces, edges};
}

Mass mesh_mass(const Table& vertices, const std::vector<std::vector<int>>& triangles) {
  std::vector<gelenk::Triangle> all;
  for (const auto& t : triangles) all.push_back({t.at(0), t.at(1), t.at(2)});
  return listed(gelenk::mass_properties_of_mesh(points3(vertices), all));
}

// Name, whether bounded, whether made of points, and the fields as (name, unit).
using Kind = std::tuple<std::string, bool, bool, std::vector<std::pair<std::string, std::string>>>;

std::vector<Kind> kinds() {
  std::vector<Kind> out;
  for (const gelenk::ShapeKind& kind : gelenk::shape_kinds()) {
    std::vector<std::pair<std::string, std::string>> fields;
    for (const gelenk::Field& field : kind.fields) fields.emplace_back(field.name, field.unit);
    out.emplace_back(kind.kind, kind.bounded, kind.of_points, fields);
  }
  return out;
}

}  // namespace

void bind_shapes(nb::module_& m) {
  nb::class_<gelenk::AnyShape>(m, "Shape")
      .def(
          "__init__",
          [](gelenk::AnyShape* self, const std::string& kind, const Numbers& dimensions, const Table& points) {
            new (self) gelenk::AnyShape(shape(kind, dimensions, points));
          },
          nb::arg("kind"), nb::arg("dimensions") = Numbers(), nb::arg("points") = Table())
      .def("mass", mass_of)
      .def("support", support_of)
      .def("size", [](const gelenk::AnyShape& s) { return gelenk::size_of(s); })
      .def("bounds", [](const gelenk::AnyShape& s, const Numbers& X) { return listed(gelenk::bounds(s, pose(X))); });
  m.def("shape_kinds", kinds);
  m.def("hull", hull);
  m.def("mesh_mass", mesh_mass);
}

}  // namespace native
