// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "joint/registry.h"
#include "scene/check.h"
#include "scene/text.h"

namespace gelenk {
namespace {

const Joint* find_joint(const Scene& scene, const std::string& name) {
  const auto found = std::ranges::find(scene.joints, name, &Joint::name);
  return found == scene.joints.end() ? nullptr : &*found;
}

void check_motor(const Scene& scene, const Motor& motor, Faults& faults, bool partial) {
  const std::string path = "motors." + text::printable(motor.name);
  check_finite(&motor.gear_ratio, 1, path + ".gear_ratio", faults);
  if (motor.gear_ratio == 0) faults.add(path + ".gear_ratio", "0", "a number other than 0");
  check_finite(&motor.rotor_inertia, 1, path + ".rotor_inertia", faults);
  if (motor.rotor_inertia < 0) faults.add(path + ".rotor_inertia", text::number(motor.rotor_inertia), "0 or more");
  const Joint* joint = check_joint_name(scene, motor.joint, path + ".joint", faults, partial);
  if (joint == nullptr) return;
  const JointKind* kind = find_joint_kind(joint->type);
  if (kind == nullptr || !kind->effort.name.empty()) return;
  std::vector<std::string> driven;
  for (const JointKind& k : joint_kinds()) {
    if (!k.effort.name.empty()) driven.emplace_back(k.name);
  }
  faults.add(path + ".joint", text::quoted(motor.joint) + ", a " + joint->type + " joint",
             "a joint of one of the types " + text::list(driven));
}

void check_force(const Scene& scene, const Force& force, Faults& faults, bool partial) {
  const std::string path = "forces." + text::printable(force.name);
  if (force.type == ForceType::wrench) {
    check_frame(force.at, scene, path, faults, partial);
    if (force.at.body == ground) faults.add(path + ".body", "'ground'", "a body that a force can move");
    check_finite(force.force.data(), 3, path + ".force", faults);
    check_finite(force.torque.data(), 3, path + ".torque", faults);
    return;
  }
  check_frame(force.from, scene, path + ".from", faults, partial);
  check_frame(force.to, scene, path + ".to", faults, partial);
  if (force.from.body == force.to.body && !force.from.body.empty()) {
    faults.add(path, text::quoted(force.from.body) + " at both ends", "two different bodies");
  }
  for (const auto& [value, field] : {std::pair(force.stiffness, "stiffness"), std::pair(force.damping, "damping"),
                                     std::pair(force.length, "length")}) {
    const std::string where = path + "." + field;
    check_finite(&value, 1, where, faults);
    if (value < 0) faults.add(where, text::number(value), "0 or more");
  }
}

void check_sensor(const Scene& scene, const Sensor& sensor, Faults& faults, bool partial) {
  const std::string path = "sensors." + text::printable(sensor.name);
  if (sensor.type == SensorType::reaction) check_joint_name(scene, sensor.joint, path + ".joint", faults, partial);
  if (sensor.type == SensorType::frame) check_frame(sensor.frame, scene, path, faults, partial);
}

}  // namespace

const Joint* check_joint_name(const Scene& scene, const std::string& name, const std::string& path, Faults& faults,
                              bool partial) {
  if (partial && name.empty()) return nullptr;
  const Joint* joint = find_joint(scene, name);
  if (joint != nullptr) return joint;
  std::vector<std::string> names;
  for (const Joint& j : scene.joints) names.push_back(j.name);
  faults.add(path, text::quoted(name), text::one_of(name, names, "joints"));
  return nullptr;
}

void check_elements(const Scene& scene, Faults& faults, bool partial) {
  for (const Motor& motor : scene.motors) check_motor(scene, motor, faults, partial);
  for (const Force& force : scene.forces) check_force(scene, force, faults, partial);
  for (const Sensor& sensor : scene.sensors) check_sensor(scene, sensor, faults, partial);
}

}  // namespace gelenk
