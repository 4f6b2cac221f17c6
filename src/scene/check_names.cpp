// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>
#include <set>

#include "joint/registry.h"
#include "scene/check.h"
#include "scene/text.h"
#include "scene/units.h"

namespace gelenk {
namespace {

constexpr std::size_t longest_name = 200;  // characters, as of the scene's own

template <class Element>
void check_section(const std::vector<Element>& elements, const std::string& section, Faults& faults) {
  std::set<std::string> seen;
  for (const Element& element : elements) {
    const std::string path = section + "." + text::printable(element.name);
    if (element.name == ground) {
      faults.add(path, "the name 'ground'", "another: 'ground' is the body that stands still");
    } else if (!text::is_identifier(element.name)) {
      faults.add(path, "the name " + text::quoted(element.name), "a letter or _, then letters, digits or _");
    } else if (element.name.size() > longest_name) {
      faults.add(section + "." + element.name.substr(0, 20) + "...",
                 "a name of " + std::to_string(element.name.size()) + " characters",
                 "at most " + std::to_string(longest_name));
    }
    if (!seen.insert(element.name).second) faults.add(path, "twice", "every name once");
  }
}

// Who has which structured name ("A.phi"), without indices.
class Names {
 public:
  explicit Names(Faults& faults) : faults_(faults) {}

  // At most one fault for each pair of owners.
  void take(const std::string& owner, const std::string& element, const std::vector<std::string>& suffixes) {
    std::set<std::string> told;
    for (const std::string& suffix : suffixes) {
      const std::string name = element + "." + suffix;
      const std::string& first = owners_.try_emplace(name, owner).first->second;
      if (first == owner || !told.insert(first).second) continue;
      faults_.add(owner, "the variable " + name + ", which " + first + " has already",
                  "names that keep their variables apart");
    }
  }

 private:
  Faults& faults_;
  std::map<std::string, std::string> owners_;
};

std::vector<std::string> joint_suffixes(const Joint& joint) {
  std::vector<std::string> out = {"fixed", "damping", "stiffness", "spring_reference", "stop", "parent", "child"};
  const JointKind* kind = find_joint_kind(joint.type);
  if (kind == nullptr) return out;
  for (const auto quantities : {kind->q, kind->v, kind->a}) {
    for (const QuantityGroup& group : groups(quantities)) {
      out.push_back(group.name);
      out.push_back(group.name + "_start");
    }
  }
  return out;
}

std::vector<std::string> motor_suffixes(const Scene& scene, const Motor& motor) {
  std::vector<std::string> out = {"gear_ratio", "rotor_inertia"};
  for (const Joint& joint : scene.joints) {
    const JointKind* kind = joint.name == motor.joint ? find_joint_kind(joint.type) : nullptr;
    if (kind != nullptr && !kind->effort.name.empty()) out.emplace_back(kind->effort.name);
  }
  return out;
}

std::vector<std::string> force_suffixes(const Force& force) {
  if (force.type == ForceType::spring_damper) return {"stiffness", "damping", "length"};
  return {"force", "torque", "f", "t"};
}

std::vector<std::string> sensor_suffixes(const Sensor& sensor) {
  switch (sensor.type) {
    case SensorType::reaction:
      return {"f", "t"};
    case SensorType::frame:
      return {"r", "Q", "v", "w"};
    case SensorType::energy:
      return {"kinetic", "potential", "total"};
  }
  return {};
}

std::vector<std::string> constraint_suffixes(const Scene& scene, const Constraint& constraint) {
  switch (constraint.type) {
    case ConstraintType::motion: {
      const auto joint = std::ranges::find(scene.joints, constraint.joint, &Joint::name);
      const JointKind* kind = joint == scene.joints.end() ? nullptr : find_joint_kind(joint->type);
      if (kind == nullptr) return {};
      const MotionSignals signals = motion_signals(*kind, constraint);
      std::vector<std::string> out = {signals.effort, "polynomial", "sine", "speed"};
      if (!signals.input.empty()) out.push_back(signals.input);
      return out;
    }
    case ConstraintType::gear:
    case ConstraintType::rack:
      return {"tau", "f", "ratio", "radius", "offset"};
    case ConstraintType::rolling:
      return {"f_n", "f_long", "f_lat", "r", "radius"};
    case ConstraintType::knife_edge:
      return {"f"};
  }
  return {};
}

}  // namespace

void check_names(const Scene& scene, Faults& faults) {
  check_section(scene.bodies, "bodies", faults);
  check_section(scene.joints, "joints", faults);
  check_section(scene.motors, "motors", faults);
  check_section(scene.forces, "forces", faults);
  check_section(scene.constraints, "constraints", faults);
  check_section(scene.sensors, "sensors", faults);

  Names names(faults);
  const std::string always = "every mechanism";
  names.take(always, "assembly", {"tolerance"});
  names.take(always, "constraints", {"position", "velocity"});
  names.take(always, "energy", {"kinetic", "potential", "total"});
  names.take(always, "solver",
             {"steps", "evaluations", "rejected_steps", "jacobians", "singular_positions", "tolerance", "formulation",
              "integrator", "step", "start"});
  for (const Body& body : scene.bodies) names.take("bodies." + body.name, body.name, {"m", "mass", "com", "inertia"});
  for (const Joint& joint : scene.joints) names.take("joints." + joint.name, joint.name, joint_suffixes(joint));
  for (const Motor& motor : scene.motors) names.take("motors." + motor.name, motor.name, motor_suffixes(scene, motor));
  for (const Force& force : scene.forces) names.take("forces." + force.name, force.name, force_suffixes(force));
  for (const Constraint& constraint : scene.constraints) {
    names.take("constraints." + constraint.name, constraint.name, constraint_suffixes(scene, constraint));
  }
  for (const Sensor& sensor : scene.sensors) names.take("sensors." + sensor.name, sensor.name, sensor_suffixes(sensor));
}

}  // namespace gelenk
