// SPDX-License-Identifier: BSD-3-Clause
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

}  // namespace

void read_bodies(const Json& section, Reader& reader) {
  Faults& faults = reader.faults;
  each_entry(section, "bodies", faults, [&](const std::string& name, const Json& value, const std::string& path) {
    Body body;
    body.name = name;
    Fields fields(value, path, faults, "a mapping with mass, com, inertia, pose");
    read_fields(fields, Body::fields(), &body, {});
    if (const Json* inertia = fields.find("inertia")) {
      body.inertia = read_inertia(*inertia, fields.path("inertia"), faults);
    }
    if (const Json* pose = fields.find("pose")) {
      Fields inner(*pose, fields.path("pose"), faults, "{position, rotation}");
      body.pose = read_pose(inner);
      inner.done();
    }
    fields.done();
    reader.scene.bodies.push_back(std::move(body));
  });
}

}  // namespace gelenk
