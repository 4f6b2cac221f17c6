// SPDX-License-Identifier: BSD-3-Clause
// Reads the shapes of bodies and of the ground.
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

void read_points(const Json& value, const std::string& path, Faults& faults, AnyShape& shape) {
  if (!value.is_array()) {
    faults.add(path, shown(value), "a list of points [x, y, z] in m");
    return;
  }
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const auto point = read_vector(value[i], path + "[" + std::to_string(i + 1) + "]", faults, "m");
    if (!point) return;
    points.push_back(*point);
  }
  try {
    shape = make_shape_of_points(shape.index(), std::move(points));
  } catch (const std::invalid_argument& fault) {
    faults.add(path, fault.what(), "points that span a volume");
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
    if (kind.of_points) {
      read_points(*dimensions, own, faults, out.is);
    } else if (kind.bounded) {
      read_dimensions(*dimensions, own, faults, kind, out.is);
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
