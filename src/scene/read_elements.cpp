// SPDX-License-Identifier: BSD-3-Clause
// Motors, forces and sensors.
#include <algorithm>
#include <utility>

#include "joint/registry.h"
#include "scene/reader.h"
#include "scene/words.h"

namespace gelenk {
namespace {

std::string rotor_unit(const Scene& scene, const std::string& name) {
  const auto joint = std::ranges::find(scene.joints, name, &Joint::name);
  const JointKind* kind = joint == scene.joints.end() ? nullptr : find_joint_kind(joint->type);
  if (kind == nullptr) return {};
  return kind->effort.unit == "N" ? "kg" : "kg m2";
}

BodyFrame read_point(Fields& fields, const std::string& key, Reader& reader) {
  const Json* value = fields.require(key, "{body, position} or the name of a body");
  if (value != nullptr) return read_body_frame(*value, fields.path(key), reader.faults, reader.bodies, false);
  return {.body = "", .X_BF = {}};
}

void read_spring_damper(Fields& fields, Reader& reader, Force& force) {
  force.from = read_point(fields, "from", reader);
  force.to = read_point(fields, "to", reader);
  force.stiffness = fields.number("stiffness", 0, "N/m", Allowed::not_negative);
  force.damping = fields.number("damping", 0, "N s/m", Allowed::not_negative);
  force.length = fields.number("length", 0, "m", Allowed::not_negative);
}

void read_wrench(Fields& fields, Reader& reader, Force& force) {
  force.at = read_own_frame(fields, reader);
  force.force = fields.vector("force", "N");
  force.torque = fields.vector("torque", "N m");
  force.in_body = fields.choice("frame", words::load_frames, "world") == "body";
  force.input = fields.flag("input", false);
}

}  // namespace

std::string read_joint_name(Fields& fields, const std::string& field, Reader& reader) {
  const Json* value = fields.require(field, "the name of a joint");
  if (value == nullptr) return {};
  const auto name = read_text(*value, fields.path(field), reader.faults, "the name of a joint");
  if (!name || reader.joints.empty()) return {};  // no joints: told already
  if (std::ranges::find(reader.joints, *name) != reader.joints.end()) return *name;
  reader.faults.add(fields.path(field), text::quoted(*name), text::one_of(*name, reader.joints, "joints"));
  return {};
}

BodyFrame read_own_frame(Fields& fields, Reader& reader) {
  BodyFrame frame;
  const Json* body = fields.require("body", "the name of a body");
  frame.body = body != nullptr ? read_body_name(*body, fields.path("body"), reader.faults, reader.bodies) : "";
  frame.X_BF = read_pose(fields);
  return frame;
}

void read_motors(const Json& section, Reader& reader) {
  each_entry(section, "motors", reader.faults,
             [&](const std::string& name, const Json& value, const std::string& path) {
               Motor motor;
               motor.name = name;
               Fields fields(value, path, reader.faults, "a mapping with joint, gear_ratio, rotor_inertia");
               motor.joint = read_joint_name(fields, "joint", reader);
               motor.gear_ratio = fields.number("gear_ratio", 1, "", Allowed::not_zero);
               motor.rotor_inertia =
                   fields.number("rotor_inertia", 0, rotor_unit(reader.scene, motor.joint), Allowed::not_negative);
               fields.done();
               reader.scene.motors.push_back(std::move(motor));
             });
}

void read_forces(const Json& section, Reader& reader) {
  each_entry(section, "forces", reader.faults,
             [&](const std::string& name, const Json& value, const std::string& path) {
               Force force;
               force.name = name;
               Fields fields(value, path, reader.faults, "a mapping with type");
               const std::string type = fields.choice("type", words::forces, "");
               if (type.empty()) {
                 reader.doubtful.insert(name);
                 return;
               }
               force.type = type == "wrench" ? ForceType::wrench : ForceType::spring_damper;
               if (type == "wrench") {
                 read_wrench(fields, reader, force);
               } else {
                 read_spring_damper(fields, reader, force);
               }
               fields.done();
               reader.scene.forces.push_back(std::move(force));
             });
}

void read_sensors(const Json& section, Reader& reader) {
  each_entry(section, "sensors", reader.faults,
             [&](const std::string& name, const Json& value, const std::string& path) {
               Sensor sensor;
               sensor.name = name;
               Fields fields(value, path, reader.faults, "a mapping with type");
               const std::string type = fields.choice("type", words::sensors, "");
               if (type.empty()) return;
               if (type == "reaction") {
                 sensor.type = SensorType::reaction;
                 sensor.joint = read_joint_name(fields, "joint", reader);
               } else if (type == "frame") {
                 sensor.type = SensorType::frame;
                 sensor.frame = read_own_frame(fields, reader);
               } else {
                 sensor.type = SensorType::energy;
               }
               fields.done();
               reader.scene.sensors.push_back(std::move(sensor));
             });
}

}  // namespace gelenk
