// SPDX-License-Identifier: BSD-3-Clause
// Reads the shapes of bodies and of the ground.
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "math/rotations.h"
#include "scene_file/element_fields.h"
#include "scene_file/reader.h"

namespace gelenk {
namespace {

std::vector<std::string> names_of_kinds() {
  std::vector<std::string> out;
  for (const ShapeKind& kind : shape_kinds()) out.emplace_back(kind.kind);
  return out;
}

// The dimensions of a shape with one field are its value, those of a shape with several a mapping.
void read_dimensions(const Json& value, const std::string& path, Faults& faults, const ShapeKind& kind,
                     AnyShape& shape) {
  if (kind.fields.size() == 1) {
    read_field(value, path, faults, kind.fields.front(), data_of(shape), {});
    return;
  }
  std::vector<std::string> names;
  for (const Field& field : kind.fields) names.emplace_back(field.name);
  Fields fields(value, path, faults, "a mapping with " + text::list(names));
  read_fields(fields, kind.fields, data_of(shape), {});
  fields.done();
}

std::optional<std::vector<Eigen::Vector3d>> read_points(const Json& value, const std::string& path, Faults& faults) {
  if (!value.is_array()) {
    faults.add(path, shown(value), "a list of points [x, y, z] in m");
    return {};
  }
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const auto point = read_vector(value[i], path + "[" + std::to_string(i + 1) + "]", faults, "m");
    if (!point) return {};
    points.push_back(*point);
  }
  return points;
}

std::optional<Triangle> read_triangle(const Json& value) {
  if (!value.is_array() || value.size() != 3) return {};
  Triangle out{};
  for (std::size_t i = 0; i < 3; ++i) {
    if (!value[i].is_number_integer()) return {};
    const auto number = value[i].get<double>();
    if (number < 0 || number > std::numeric_limits<int>::max()) return {};
    out[i] = static_cast<int>(number);
  }
  return out;
}

std::optional<std::vector<Triangle>> read_triangles(const Json& value, const std::string& path, Faults& faults) {
  constexpr const char* expected = "three numbers of points, counted from 0";
  if (!value.is_array()) {
    faults.add(path, shown(value), std::string("a list of triangles, each of ") + expected);
    return {};
  }
  std::vector<Triangle> out;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const auto triangle = read_triangle(value[i]);
    if (!triangle) {
      faults.add(path + "[" + std::to_string(i + 1) + "]", shown(value[i]), expected);
      return {};
    }
    out.push_back(*triangle);
  }
  return out;
}

void read_hull(const Json& value, const std::string& path, Faults& faults, std::size_t kind, Stored<AnyShape>& shape) {
  auto points = read_points(value, path, faults);
  if (!points) return;
  try {
    shape = make_shape_of_points(kind, std::move(*points));
  } catch (const std::invalid_argument& fault) {
    faults.add(path, fault.what(), "points that span a volume");
  }
}

// Files of meshes are read by the Python package, which puts their points and triangles in their place.
void read_mesh(const Json& value, const std::string& path, Faults& faults, std::size_t kind, Stored<AnyShape>& shape) {
  constexpr const char* expected = "a mapping with points and triangles";
  if (value.is_string() || (value.is_object() && value.contains("file"))) {
    faults.add(path, "a file", std::string(expected) + "; only the Python package reads files of meshes");
    return;
  }
  Fields fields(value, path, faults, expected);
  if (!fields.valid()) return;
  const Json* of_points = fields.require("points", "a list of points [x, y, z] in m");
  const Json* of_triangles = fields.require("triangles", "a list of triangles");
  fields.done();
  if (of_points == nullptr || of_triangles == nullptr) return;
  auto points = read_points(*of_points, fields.path("points"), faults);
  auto triangles = read_triangles(*of_triangles, fields.path("triangles"), faults);
  if (!points || !triangles) return;
  try {
    shape = make_shape_of_points(kind, std::move(*points), std::move(*triangles));
  } catch (const std::invalid_argument& fault) {
    faults.add(path, fault.what(), "a closed surface, its triangles counterclockwise as seen from outside");
  }
}

BodyShape read_shape(const std::string& name, const Json& value, const std::string& path, Faults& faults) {
  BodyShape out;
  out.name = name;
  const std::vector<std::string> names = names_of_kinds();
  Fields fields(value, path, faults,
                "a mapping with one of " + text::list(names) + ", and position, rotation, surface");
  if (!fields.valid()) return out;
  std::string found;
  for (std::size_t n = 0; n < names.size(); ++n) {
    const Json* dimensions = fields.find(names[n]);
    if (dimensions == nullptr) continue;
    if (!found.empty()) {
      faults.add(path, found + " and " + names[n], "one shape");
      continue;
    }
    found = names[n];
    const ShapeKind& kind = shape_kinds()[n];
    out.is = make_shape(n);
    const std::string own = fields.path(found);
    if (kind.of_triangles) {
      read_mesh(*dimensions, own, faults, n, out.is);
    } else if (kind.of_points) {
      read_hull(*dimensions, own, faults, n, out.is);
    } else if (kind.bounded) {
      read_dimensions(*dimensions, own, faults, kind, *out.is);
    } else if (const auto normal = read_direction(*dimensions, own, faults)) {
      out.X_BS.R = rotation_taking_z_to(*normal);
    }
  }
  if (found.empty()) faults.add(path, "no shape", "one of " + text::list(names));
  const Pose3 X_BS = read_pose(fields);
  out.X_BS = X_BS * out.X_BS;
  if (const Json* surface = fields.find("surface"))
    out.surface = read_text(*surface, fields.path("surface"), faults, "the name of a surface").value_or("");
  fields.done();
  return out;
}

}  // namespace

std::vector<BodyShape> read_shapes(const Json& value, const std::string& path, Faults& faults) {
  std::vector<BodyShape> out;
  each_entry(value, path, faults, [&](const std::string& name, const Json& shape, const std::string& of) {
    out.push_back(read_shape(name, shape, of, faults));
  });
  return out;
}

}  // namespace gelenk
