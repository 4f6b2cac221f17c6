// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include "joint/kinds.h"
#include "math/rotations.h"
#include "scene/quantity_groups.h"
#include "scene_file/element_fields.h"
#include "scene_file/reader.h"

namespace gelenk {
namespace {

// Axes at a smaller angle [rad] are parallel: the direction normal to both would be lost to round-off.
constexpr double min_axis_angle = 1e-6;

std::vector<std::string> kind_names() {
  std::vector<std::string> names;
  for (const JointKind& kind : joint_kinds()) names.emplace_back(kind.name);
  return names;
}

void read_one_axis(const Json* axis, Fields& fields, Joint& joint) {
  if (axis == nullptr) return;
  joint.axes[0] = read_direction(*axis, fields.path("axis"), fields.faults()).value_or(joint.axes[0]);
}

void read_two_axes(const Json* axes, Fields& fields, Joint& joint) {
  if (axes == nullptr) return;
  const std::string path = fields.path("axes");
  if (!axes->is_array() || axes->size() != 2) {
    fields.faults().add(path, shown(*axes), "a list of 2 directions");
    return;
  }
  const auto a = read_direction((*axes)[0], path + "[1]", fields.faults());
  const auto b = read_direction((*axes)[1], path + "[2]", fields.faults());
  if (!a || !b) return;
  if (a->cross(*b).norm() < min_axis_angle) {
    fields.faults().add(path, "two parallel directions", "two that are not parallel");
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
  joint.axes = default_axes(kind);
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
      faults.add(fields.path(key), "a position or rotation in addition to 'at'",
                 "either 'at' or the frames in both bodies");
    }
  }
  if (at == nullptr) return;
  Fields inner(*at, fields.path("at"), faults, "{position, rotation} in the world");
  const Pose3 X_WF = read_pose(inner);
  inner.done();
  for (BodyFrame* frame : {&joint.parent, &joint.child}) {
    frame->X_BF = orthonormalized(reference_pose(reader.scene, frame->body).inverse() * X_WF);
  }
}

// Reads a field along each velocity: a number for one degree of freedom, a list for several.
void read_along(Fields& fields, const JointForceKind& kind, const Field& field, Joint& joint) {
  const std::string key(field.name);
  const Json* value = fields.find(key);
  if (value == nullptr) return;
  const std::string path = fields.path(key);
  const std::size_t n = joint.along.size();
  const JointKind& of = kind_of(*joint.is);
  const auto element = [&](std::size_t i) { return kind.find(*joint.along[i]); };
  if (n == 1) return read_field(*value, path, fields.faults(), field, element(0), coordinate_of(of, 0));
  const auto list = read_list(*value, path, fields.faults(), n, common_unit(field, of), field.range);
  for (std::size_t i = 0; list && i < n; ++i) field.of<double>(element(i)) = (*list)[i];
}

void refuse(const Json& value, const std::string& path, std::string_view name, const JointForceKind& kind,
            const JointKind& of, Faults& faults) {
  faults.add(
      path, shown(value),
      "no " + std::string(name) + ": " + a_kind(of) + " " + (of.nv == 0 ? "cannot move" : std::string(kind.misfit)));
}

// Fields of the joint itself that are in a group of the file: "friction.translation" in "friction".
std::vector<Field> fields_in_group(const JointKind& kind, std::string_view group) {
  std::vector<Field> out;
  for (const Field& field : kind.fields) {
    const std::size_t dot = field.name.find('.');
    if (dot == std::string_view::npos || field.name.substr(0, dot) != group) continue;
    out.push_back(field);
    out.back().name.remove_prefix(dot + 1);
  }
  return out;
}

// A name of the only coordinate, where its group would have names.
bool names_only_coordinate(const Json& value, const std::string& path, const JointForceKind& kind, const JointKind& of,
                           Faults& faults) {
  const std::string name(of.q[0].name);
  if (of.nv != 1 || !value.is_object() || !value.contains(name)) return false;
  faults.add(path, text::quoted(name),
             "a mapping with fields of " + std::string(kind.group) + ": " + a_kind(of) +
                 " has one coordinate, whose name is not written");
  return true;
}

// Reads a group of fields along a coordinate; after an error the whole group is removed, since its numbers belong
// together.
void read_group(const Json& value, const std::string& path, const JointForceKind& kind, std::size_t i, Reader& reader,
                Joint& joint) {
  const std::size_t before = reader.faults.count();
  if (names_only_coordinate(value, path, kind, kind_of(*joint.is), reader.faults)) {
    reader.suspect_names.insert(joint.name);
    return;
  }
  JointForces& at = *joint.along[i];
  std::vector<std::string> names;
  for (const Field& field : kind.fields) names.emplace_back(field.name);
  Fields fields(value, path, reader.faults, "{" + text::list(names) + "}");
  kind.emplace(at);
  const Coordinate coordinate = coordinate_of(kind_of(*joint.is), static_cast<int>(i));
  if (fields.valid()) read_fields(fields, kind.fields, kind.find(at), coordinate, reader.names);
  fields.done();
  if (reader.faults.count() == before) check_force(joint, i, path, kind, reader.faults);
  if (reader.faults.count() == before) return;
  kind.erase(at);
  reader.suspect_names.insert(joint.name);
}

// Of a joint with several coordinates: groups by the names of coordinates.
void read_groups(const Json& value, const std::string& path, const JointForceKind& kind, Reader& reader, Joint& joint) {
  const JointKind& of = kind_of(*joint.is);
  std::vector<std::string> names;
  for (const Quantity& q : of.q) names.emplace_back(q.name);
  const std::vector<Field> own = fields_in_group(of, kind.group);
  std::vector<std::string> all = names;
  for (const Field& field : own) all.emplace_back(field.name);
  const std::string expected = "a mapping with coordinates of " + a_kind(of) + ": " + text::list(all);
  const auto is_of_one = [&](const Field& field) { return value.is_object() && value.contains(field.name); };
  if (const auto found = std::ranges::find_if(kind.fields, is_of_one); found != kind.fields.end()) {
    const std::string key(found->name);
    reader.suspect_names.insert(joint.name);
    return reader.faults.add(path, text::quoted(key), expected + ", as {" + names[0] + ": {" + key + ": ...}}");
  }
  if (value.is_object() && value.empty()) return reader.faults.add(path, "nothing", expected);
  Fields fields(value, path, reader.faults, expected);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Json* group = fields.find(names[i]);
    if (group != nullptr) read_group(*group, fields.path(names[i]), kind, i, reader, joint);
  }
  read_fields(fields, own, data_of(*joint.is), {});
  fields.done();
}

// Returns the keys of a joint force in scene files.
std::vector<std::string> keys_of(const JointForceKind& kind) {
  if (!kind.group.empty()) return {std::string(kind.group)};
  std::vector<std::string> out;
  for (const Field& field : kind.fields) out.emplace_back(field.name);
  return out;
}

// Adds errors for forces that this kind of joint cannot have.
void refuse_forces(Fields& fields, const JointForceKind& kind, Reader& reader, const Joint& joint) {
  for (const std::string& key : keys_of(kind)) {
    const auto fields_of_joint = kind_of(*joint.is).fields;  // it may have a group of its own
    if (std::ranges::find(fields_of_joint, key, &Field::name) != fields_of_joint.end()) continue;
    const Json* value = fields.find(key);
    if (value == nullptr) continue;
    refuse(*value, fields.path(key), key, kind, kind_of(*joint.is), reader.faults);
    if (!kind.group.empty()) reader.suspect_names.insert(joint.name);
  }
}

void read_forces(Fields& fields, Reader& reader, Joint& joint) {
  const JointKind& of = kind_of(*joint.is);
  joint.along.resize(static_cast<std::size_t>(of.nv));
  for (const JointForceKind& kind : joint_force_kinds()) {
    const std::string group(kind.group);
    if (!kind.fits(of)) {
      refuse_forces(fields, kind, reader, joint);
    } else if (group.empty()) {
      for (const Field& field : kind.fields) read_along(fields, kind, field, joint);
    } else if (const Json* value = fields.find(group)) {
      if (of.nv == 1 || kind.of_joint) {
        read_group(*value, fields.path(group), kind, 0, reader, joint);
      } else {
        read_groups(*value, fields.path(group), kind, reader, joint);
      }
    }
  }
}

// Accepts the fields of all kinds of joints if the kind is unknown, so that they are not reported as unknown.
void accept_fields_of_every_kind(Fields& fields) {
  for (const char* key : {"axis", "axes", "start"}) fields.find(key);
  for (const JointForceKind& kind : joint_force_kinds()) {
    if (!kind.group.empty()) fields.find(std::string(kind.group));
    for (const Field& field : kind.fields) {
      if (kind.group.empty()) fields.find(std::string(field.name));
    }
  }
  for (const JointKind& kind : joint_kinds()) {
    for (const Field& field : kind.fields) fields.find(std::string(field.name.substr(0, field.name.find('.'))));
  }
}

void read_joint(const Json& value, const std::string& path, Reader& reader, Joint& joint) {
  Fields fields(value, path, reader.faults, "a mapping with type, parent, child");
  joint.type = fields.choice("type", kind_names(), "");
  const JointKind* kind = find_joint_kind(joint.type);
  if (kind == nullptr) {
    accept_fields_of_every_kind(fields);
    reader.suspect_names.insert(joint.name);
    read_frames(fields, reader, joint);
    fields.done();
    return;
  }
  read_axes(fields, *kind, joint);
  read_frames(fields, reader, joint);
  joint.start = free_start(*kind);
  if (const Json* start = fields.find("start")) read_start(*start, fields.path("start"), reader.faults, joint);
  joint.is = make_joint(joint.type, joint.axes);
  for (const Field& field : kind->fields) {
    if (field.name.find('.') == std::string_view::npos)
      read_fields(fields, std::span(&field, 1), data_of(*joint.is), {});
  }
  read_forces(fields, reader, joint);
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
