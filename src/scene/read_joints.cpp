// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include "joint/registry.h"
#include "scene/reader.h"
#include "scene/units.h"

namespace gelenk {
namespace {

// Below this angle [rad] two axes are parallel: the third, normal to both, would be lost in rounding.
constexpr double parallel = 1e-6;

std::vector<std::string> kind_names() {
  std::vector<std::string> names;
  for (const JointKind& kind : joint_kinds()) names.emplace_back(kind.name);
  return names;
}

std::string a_kind(const JointKind& kind) { return "a " + std::string(kind.name) + " joint"; }

void read_one_axis(const Json* axis, Fields& fields, Joint& joint) {
  joint.axes = {Eigen::Vector3d::UnitZ()};
  if (axis == nullptr) return;
  joint.axes[0] = read_direction(*axis, fields.path("axis"), fields.faults()).value_or(joint.axes[0]);
}

void read_two_axes(const Json* axes, Fields& fields, Joint& joint) {
  joint.axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};
  if (axes == nullptr) return;
  const std::string path = fields.path("axes");
  if (!axes->is_array() || axes->size() != 2) {
    fields.faults().add(path, shown(*axes), "a list of 2 directions");
    return;
  }
  const auto a = read_direction((*axes)[0], path + "[1]", fields.faults());
  const auto b = read_direction((*axes)[1], path + "[2]", fields.faults());
  if (!a || !b) return;
  if (a->cross(*b).norm() < parallel) {
    fields.faults().add(path, "two parallel directions", "two that cross");
    return;
  }
  joint.axes = {*a, *b};
}

void read_axes(Fields& fields, const JointKind& kind, Joint& joint) {
  const Json* axis = fields.find("axis");
  const Json* axes = fields.find("axes");
  Faults& faults = fields.faults();
  if (axis != nullptr && kind.axes != 1) {
    faults.add(fields.path("axis"), "an axis",
               kind.axes == 0 ? "none: " + a_kind(kind) + " has no axis"
                              : "'axes': " + a_kind(kind) + " has two, axes: [[x, y, z], [x, y, z]]");
  }
  if (axes != nullptr && kind.axes != 2) {
    faults.add(fields.path("axes"), "two axes",
               kind.axes == 0 ? "none: " + a_kind(kind) + " has no axis"
                              : "'axis': " + a_kind(kind) + " has one, axis: [x, y, z]");
  }
  if (kind.axes == 1) read_one_axis(axis, fields, joint);
  if (kind.axes == 2) read_two_axes(axes, fields, joint);
}

Pose3 reference_pose(const Scene& scene, const std::string& body) {
  const auto found = std::ranges::find(scene.bodies, body, &Body::name);
  return found == scene.bodies.end() ? Pose3{} : found->pose.value_or(Pose3{});
}

void read_frames(Fields& fields, Reader& reader, Joint& joint) {
  Faults& faults = reader.faults;
  const Json* at = fields.find("at");
  for (BodyFrame* frame : {&joint.parent, &joint.child}) {
    const std::string key = frame == &joint.parent ? "parent" : "child";
    frame->body.clear();
    const Json* value = fields.require(key, "{body, position, rotation} or the name of a body");
    if (value == nullptr) continue;
    bool placed = false;
    *frame = read_body_frame(*value, fields.path(key), faults, reader.bodies, true, &placed);
    if (placed && at != nullptr) {
      faults.add(fields.path(key), "a position or rotation beside 'at'", "either 'at' or the frames in both bodies");
    }
  }
  if (at == nullptr) return;
  Fields inner(*at, fields.path("at"), faults, "{position, rotation} in the world");
  const Pose3 X_WF = read_pose(inner);
  inner.done();
  for (BodyFrame* frame : {&joint.parent, &joint.child}) {
    frame->X_BF = settled(reference_pose(reader.scene, frame->body).inverse() * X_WF);
  }
}

// A number for one degree of freedom, a list for more. unit: of the i-th.
std::vector<double> read_per_speed(Fields& fields, const std::string& key, const JointKind& kind, bool allowed_here,
                                   const std::string& unit, Allowed allowed) {
  std::vector<double> out(static_cast<std::size_t>(kind.nv), 0.0);
  const Json* value = fields.find(key);
  if (value == nullptr) return out;
  const std::string path = fields.path(key);
  if (!allowed_here) {
    const char* why = kind.nv == 0 ? " cannot move" : " has no angles that a spring could act on";
    fields.faults().add(path, shown(*value), "no " + key + ": " + a_kind(kind) + why);
  } else if (kind.nv == 1) {
    out[0] = read_number(*value, path, fields.faults(), unit, allowed).value_or(0);
  } else {
    out = read_list(*value, path, fields.faults(), out.size(), unit, allowed).value_or(out);
  }
  return out;
}

// Nothing after a fault: bounds and stiffness belong together.
std::optional<Stop> read_stop(const Json& value, const std::string& path, const JointKind& kind, Faults& faults) {
  if (!kind.stops()) {
    const std::string freedoms = kind.nv == 0 ? "cannot move" : "has " + std::to_string(kind.nv) + " freedoms, not one";
    faults.add(path, shown(value), "no stop: " + a_kind(kind) + " " + freedoms);
    return {};
  }
  const std::size_t before = faults.count();
  const JointUnits units = joint_units(kind);
  Fields fields(value, path, faults, "{lower, upper, stiffness, damping}");
  Stop stop;
  stop.lower = fields.number("lower", stop.lower, units.coordinate);
  stop.upper = fields.number("upper", stop.upper, units.coordinate);
  stop.stiffness = fields.required_number("stiffness", units.stiffness, Allowed::positive);
  stop.damping = fields.number("damping", 0, units.damping, Allowed::not_negative);
  fields.done();
  if (faults.count() > before) return {};
  return stop;
}

void read_joint(const Json& value, const std::string& path, Reader& reader, Joint& joint) {
  Fields fields(value, path, reader.faults, "a mapping with type, parent, child");
  joint.type = fields.choice("type", kind_names(), "");
  const JointKind* kind = find_joint_kind(joint.type);
  if (kind == nullptr) {
    // The rest cannot be judged without the kind, but for names and spelling.
    for (const char* key : {"axis", "axes", "start", "damping", "stiffness", "spring_reference", "stop"}) {
      fields.find(key);
    }
    reader.doubtful.insert(joint.name);
    read_frames(fields, reader, joint);
    fields.done();
    return;
  }
  read_axes(fields, *kind, joint);
  read_frames(fields, reader, joint);
  joint.start = free_start(*kind);
  if (const Json* start = fields.find("start")) read_start(*start, fields.path("start"), reader.faults, joint);
  const JointUnits units = joint_units(*kind);
  joint.damping = read_per_speed(fields, "damping", *kind, kind->nv > 0, units.damping, Allowed::not_negative);
  joint.stiffness = read_per_speed(fields, "stiffness", *kind, kind->springs(), units.stiffness, Allowed::not_negative);
  joint.spring_reference =
      read_per_speed(fields, "spring_reference", *kind, kind->springs(), units.coordinate, Allowed::any);
  if (const Json* stop = fields.find("stop")) {
    joint.stop = read_stop(*stop, fields.path("stop"), *kind, reader.faults);
    if (!joint.stop) reader.doubtful.insert(joint.name);
  }
  fields.done();
}

}  // namespace

void read_joints(const Json& section, Reader& reader) {
  each_entry(section, "joints", reader.faults,
             [&](const std::string& name, const Json& value, const std::string& path) {
               Joint joint;
               joint.name = name;
               read_joint(value, path, reader, joint);
               reader.scene.joints.push_back(std::move(joint));
             });
}

}  // namespace gelenk
