// SPDX-License-Identifier: BSD-3-Clause
#include "scene/shapes.h"
#include "scene_file/element_fields.h"
#include "scene_file/reader.h"

namespace gelenk {
namespace {

// Reads [xx, yy, zz, xy, xz, yz], or [xx, yy, zz] if the axes of B are principal axes.
Eigen::Matrix3d read_inertia(const Json& value, const std::string& path, Faults& faults) {
  Eigen::Matrix3d I = Eigen::Matrix3d::Zero();
  const std::string advice = advice::on_inertia(value);
  if (!value.is_array() || (value.size() != 3 && value.size() != 6) || !advice.empty()) {
    faults.add(path, value.is_array() && !advice.empty() ? "a 3x3 matrix" : shown(value),
               "[xx, yy, zz] or [xx, yy, zz, xy, xz, yz] in kg m2" + advice);
    return I;
  }
  const auto x = read_list(value, path, faults, value.size(), "kg m2");
  if (!x) return I;
  I.diagonal() << (*x)[0], (*x)[1], (*x)[2];
  if (x->size() == 6) {
    I(0, 1) = I(1, 0) = (*x)[3];
    I(0, 2) = I(2, 0) = (*x)[4];
    I(1, 2) = I(2, 1) = (*x)[5];
  }
  return I;
}

// Reads {density: d}: mass, center of mass and inertia are those of the shapes.
void read_density(const Json& value, Fields& of_body, Body& body) {
  Faults& faults = of_body.faults();
  Fields fields(value, of_body.path("mass"), faults, "a number in kg, or {density: number in kg/m3}");
  const double density = fields.required_number("density", "kg/m3", Range::positive);
  fields.done();
  for (const char* other : {"com", "inertia"}) {
    if (of_body.find(other) != nullptr)
      faults.add(of_body.path(other), "a value beside a density", "none: it is that of the shapes");
  }
  const MassProperties of = mass_properties(body.shapes);
  if (!(of.volume > 0)) faults.add(of_body.path("mass"), "a density without shapes", "shapes of finite size");
  body.mass = density * of.volume;
  body.com = of.center;
  body.inertia = density * of.inertia;
}

}  // namespace

void read_bodies(const Json& section, Reader& reader) {
  Faults& faults = reader.faults;
  each_entry(section, "bodies", faults, [&](const std::string& name, const Json& value, const std::string& path) {
    Body body;
    body.name = name;
    Fields fields(value, path, faults, "a mapping with mass, com, inertia, pose, shapes");
    const Json* mass = fields.find("mass");
    const bool by_density = mass != nullptr && mass->is_object();
    if (!by_density) {
      read_fields(fields, Body::fields(), &body, {});
      if (const Json* inertia = fields.find("inertia")) {
        body.inertia = read_inertia(*inertia, fields.path("inertia"), faults);
      }
    }
    if (const Json* pose = fields.find("pose")) {
      Fields inner(*pose, fields.path("pose"), faults, "{position, rotation}");
      body.pose = read_pose(inner);
      inner.done();
    }
    if (const Json* shapes = fields.find("shapes")) body.shapes = read_shapes(*shapes, fields.path("shapes"), faults);
    if (by_density) read_density(*mass, fields, body);
    fields.done();
    reader.scene.bodies.push_back(std::move(body));
  });
}

void read_ground(const Json& section, Reader& reader) {
  Fields fields(section, ground, reader.faults, "a mapping with shapes");
  if (const Json* shapes = fields.find("shapes"))
    reader.scene.ground_shapes = read_shapes(*shapes, fields.path("shapes"), reader.faults);
  fields.done();
}

}  // namespace gelenk
