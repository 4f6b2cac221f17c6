// SPDX-License-Identifier: BSD-3-Clause
// Constraints beyond joints: given motions, gears, rolling.
#include <algorithm>
#include <cmath>
#include <utility>

#include "joint/registry.h"
#include "scene/reader.h"
#include "scene/words.h"

namespace gelenk {
namespace {

const JointKind* kind_of_joint(const Scene& scene, const std::string& name) {
  const auto joint = std::ranges::find(scene.joints, name, &Joint::name);
  return joint == scene.joints.end() ? nullptr : find_joint_kind(joint->type);
}

// Any number of numbers, at least `least`.
std::vector<double> read_numbers(const Json& value, const std::string& path, Faults& faults, std::size_t least) {
  const std::string expected =
      least == 1 ? "a list of numbers" : "a list of " + std::to_string(least) + " numbers or more";
  if (!value.is_array() || value.size() < least) {
    faults.add(path, shown(value), expected);
    return {};
  }
  std::vector<double> out;
  for (std::size_t i = 0; i < value.size(); ++i) {
    const auto number = read_number(value[i], path + "[" + std::to_string(i + 1) + "]", faults, "");
    out.push_back(number.value_or(std::nan("")));
  }
  return out;
}

void read_sine(const Json& value, const std::string& path, Reader& reader, GivenMotion& motion) {
  Fields fields(value, path, reader.faults, "a mapping with amplitude, frequency, phase");
  if (!fields.valid()) return;
  motion.amplitude = fields.required_number("amplitude", "");
  motion.frequency = fields.required_number("frequency", "Hz", Allowed::not_negative);
  motion.phase = fields.number("phase", 0, "rad");
  fields.done();
}

void read_table(const Json& value, const std::string& path, Reader& reader, GivenMotion& motion) {
  Fields fields(value, path, reader.faults, "a mapping with time, value, periodic");
  if (!fields.valid()) return;
  constexpr std::size_t fewest = 2;
  if (const Json* times = fields.require("time", "a list of times [s]")) {
    motion.times = read_numbers(*times, fields.path("time"), reader.faults, fewest);
  }
  if (const Json* values = fields.require("value", "a list of as many values")) {
    motion.values = read_numbers(*values, fields.path("value"), reader.faults, fewest);
  }
  motion.periodic = fields.flag("periodic", false);
  fields.done();
}

// Which of the ways to give a motion are there; all their fields are read.
GivenMotion read_motion(Fields& fields, Reader& reader) {
  using Source = GivenMotion::Source;
  GivenMotion motion;
  std::vector<std::string> given;
  if (const Json* value = fields.find("polynomial")) {
    motion.polynomial = read_numbers(*value, fields.path("polynomial"), reader.faults, 1);
    given.emplace_back("polynomial");
  }
  if (const Json* value = fields.find("sine")) {
    read_sine(*value, fields.path("sine"), reader, motion);
    if (given.empty()) given.emplace_back("sine");
  }
  if (const Json* value = fields.find("table")) {
    motion.source = Source::table;
    read_table(*value, fields.path("table"), reader, motion);
    given.emplace_back("table");
  }
  if (fields.find("speed") != nullptr) {
    motion.source = Source::speed;
    motion.speed = fields.required_number("speed", "");
    given.emplace_back("speed");
  }
  if (fields.find("input") != nullptr) {
    const std::string what = fields.choice("input", words::motion_inputs, "");
    motion.source = what == "speed" ? Source::input_speed : Source::input;
    given.emplace_back("input");
  }
  constexpr const char* expected = "one of polynomial and sine (together or alone), table, speed, input";
  if (given.empty()) reader.faults.add(fields.path(), "no motion", expected);
  if (given.size() > 1) reader.faults.add(fields.path(), text::list(given) + " together", expected);
  return motion;
}

// The coordinate's name; that of a joint with one freedom where nothing is said.
std::string read_coordinate(Fields& fields, const std::string& joint, Reader& reader) {
  const JointKind* kind = kind_of_joint(reader.scene, joint);
  const Json* value = fields.find("coordinate");
  std::vector<std::string> names;
  if (kind != nullptr) {
    for (const Quantity& q : kind->q) names.emplace_back(q.name);
  }
  if (value == nullptr) {
    if (names.size() <= 1) return names.empty() ? std::string() : names[0];
    reader.faults.add(fields.path("coordinate"), "nothing", text::one_of({}, names, "coordinates of " + joint));
    return {};
  }
  const auto name = read_text(*value, fields.path("coordinate"), reader.faults, "the name of a coordinate");
  if (!name || kind == nullptr) return {};
  if (std::ranges::find(names, *name) != names.end()) return *name;
  reader.faults.add(fields.path("coordinate"), text::quoted(*name),
                    text::one_of(*name, names, "coordinates of " + joint));
  return {};
}

void read_contact(Fields& fields, Reader& reader, Constraint& constraint) {
  constraint.at = read_own_frame(fields, reader);
  if (fields.find("axis") != nullptr) {
    const Eigen::Vector3d axis = fields.vector("axis", "");
    if (axis.norm() > 0) {
      constraint.axis = axis.normalized();
    } else {
      reader.faults.add(fields.path("axis"), "a vector of length 0", "a direction");
    }
  }
  if (const Json* value = fields.find("on")) {
    constraint.on = read_body_frame(*value, fields.path("on"), reader.faults, reader.bodies, true);
  }
  if (constraint.type == ConstraintType::rolling) {
    constraint.radius = fields.required_number("radius", "m", Allowed::positive);
  }
}

void read_constraint(Fields& fields, Reader& reader, Constraint& constraint) {
  switch (constraint.type) {
    case ConstraintType::motion:
      constraint.joint = read_joint_name(fields, "joint", reader);
      constraint.coordinate = read_coordinate(fields, constraint.joint, reader);
      constraint.motion = read_motion(fields, reader);
      return;
    case ConstraintType::gear:
      constraint.joint = read_joint_name(fields, "joint", reader);
      constraint.other = read_joint_name(fields, "with", reader);
      if (fields.find("carrier") != nullptr) constraint.carrier = read_joint_name(fields, "carrier", reader);
      constraint.ratio = fields.required_number("ratio", "", Allowed::not_zero);
      constraint.offset = fields.number("offset", 0, "rad");
      return;
    case ConstraintType::rack:
      constraint.joint = read_joint_name(fields, "rack", reader);
      constraint.other = read_joint_name(fields, "pinion", reader);
      constraint.ratio = fields.required_number("radius", "m", Allowed::not_zero);
      constraint.offset = fields.number("offset", 0, "m");
      return;
    case ConstraintType::rolling:
    case ConstraintType::knife_edge:
      read_contact(fields, reader, constraint);
      return;
  }
}

}  // namespace

void read_constraints(const Json& section, Reader& reader) {
  each_entry(section, "constraints", reader.faults,
             [&](const std::string& name, const Json& value, const std::string& path) {
               Constraint constraint;
               constraint.name = name;
               Fields fields(value, path, reader.faults, "a mapping with type");
               const std::string type = fields.choice("type", words::constraints, "");
               if (type.empty()) {
                 reader.doubtful.insert(name);
                 return;
               }
               const auto index = std::ranges::find(words::constraints, type) - words::constraints.begin();
               constraint.type = static_cast<ConstraintType>(index);
               read_constraint(fields, reader, constraint);
               fields.done();
               reader.scene.constraints.push_back(std::move(constraint));
             });
}

}  // namespace gelenk
