// SPDX-License-Identifier: BSD-3-Clause
#include "scene/signals.h"

#include <algorithm>
#include <span>
#include <stdexcept>
#include <string_view>

#include "joint/registry.h"
#include "scene/units.h"

namespace gelenk {
namespace {

std::string indexed(const std::string& owner, std::string_view quantity, int i) {
  return owner + "." + std::string(quantity) + "[" + std::to_string(i + 1) + "]";
}

const JointKind& kind_named(const std::string& type) {
  const JointKind* kind = find_joint_kind(type);
  if (kind == nullptr) throw std::out_of_range("no kind of joint is called " + type);
  return *kind;
}

// owner.quantity[1..n], described as "owner: what, x component".
void add_array(std::vector<Signal>& signals, const std::string& owner, std::string_view quantity, int n,
               std::string_view unit, const std::string& what) {
  static constexpr std::string_view components[] = {"x component", "y component", "z component", "scalar part"};
  for (int i = 0; i < n; ++i) {
    Signal s;
    s.name = indexed(owner, quantity, i);
    s.unit = unit;
    s.description = owner + ": " + what + ", " + std::string(components[i]);
    signals.push_back(s);
  }
}

void add_level(std::vector<Signal>& signals, const Joint& joint, int index, int level,
               std::span<const Quantity> quantities) {
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    const Quantity& q = quantities[i];
    signals.push_back({.name = joint.name + "." + std::string(q.name),
                       .unit = std::string(q.unit),
                       .description = joint.name + ": " + std::string(q.description),
                       .joint = index,
                       .level = level,
                       .component = static_cast<int>(i)});
  }
}

void add_reaction(std::vector<Signal>& signals, const Sensor& sensor) {
  const std::string where =
      " of joint " + sensor.joint + " on its child body, at the joint's frame M, resolved in its frame F";
  add_array(signals, sensor.name, "f", 3, "N", "force" + where);
  add_array(signals, sensor.name, "t", 3, "N.m", "torque" + where);
}

void add_frame(std::vector<Signal>& signals, const Sensor& sensor) {
  const std::string which = " of the frame on " + sensor.frame.body;
  add_array(signals, sensor.name, "r", 3, "m", "position" + which + " in the world");
  add_array(signals, sensor.name, "Q", 4, "1", "unit quaternion" + which + " in the world");
  add_array(signals, sensor.name, "v", 3, "m/s", "velocity" + which + ", resolved in the world");
  add_array(signals, sensor.name, "w", 3, "rad/s", "angular velocity" + which + ", resolved in that frame");
}

void add_energy(std::vector<Signal>& signals, const Sensor& sensor) {
  const std::string& name = sensor.name;
  signals.push_back({.name = name + ".kinetic", .unit = "J", .description = name + ": kinetic energy"});
  signals.push_back({.name = name + ".potential",
                     .unit = "J",
                     .description = name + ": potential energy of gravity, springs and stops"});
  signals.push_back(
      {.name = name + ".total", .unit = "J", .description = name + ": kinetic and potential energy together"});
}

const Joint& joint_named(const Scene& scene, const std::string& name) {
  const auto joint = std::ranges::find(scene.joints, name, &Joint::name);
  if (joint == scene.joints.end()) throw std::out_of_range("no joint is called " + name);
  return *joint;
}

void add_motion_input(std::vector<Signal>& signals, const Scene& scene, const Constraint& c) {
  const Joint& joint = joint_named(scene, c.joint);
  const JointKind& kind = kind_named(joint.type);
  const MotionSignals names = motion_signals(kind, c);
  if (names.input.empty()) return;
  const auto i = static_cast<std::size_t>(names.component);
  const bool speed = c.motion.speed_only();
  const std::string what = joint.name + "." + std::string((speed ? kind.v : kind.q)[i].name);
  signals.push_back({.name = c.name + "." + names.input,
                     .unit = names.input_unit,
                     .description = c.name + ": what " + what + " is to be",
                     .start = speed ? joint.start.v[i] : joint.start.q[i]});
}

void add_constraint(std::vector<Signal>& signals, const Scene& scene, const Constraint& c) {
  const auto add = [&](const std::string& name, const std::string& unit, const std::string& what) {
    signals.push_back({.name = c.name + "." + name, .unit = unit, .description = c.name + ": " + what});
  };
  switch (c.type) {
    case ConstraintType::motion: {
      const MotionSignals names = motion_signals(kind_named(joint_named(scene, c.joint).type), c);
      const std::string what = names.effort == "tau" ? "torque" : "force";
      return add(names.effort, names.effort_unit,
                 what + " that keeps " + c.joint + "." + c.coordinate + " to its motion");
    }
    case ConstraintType::gear:
      return add("tau", "N.m", "torque of the gear on joint " + c.joint);
    case ConstraintType::rack:
      return add("f", "N", "force of the pinion on joint " + c.joint);
    case ConstraintType::rolling: {
      const std::string on = " of the ground on the wheel, ";
      add("f_n", "N", "force" + on + "along the plane's normal");
      add("f_long", "N", "force" + on + "in the plane, along the wheel");
      add("f_lat", "N", "force" + on + "in the plane, across the wheel");
      return add_array(signals, c.name, "r", 3, "m", "position of the contact point in the world");
    }
    case ConstraintType::knife_edge:
      return add("f", "N", "force on " + c.at.body + " along the axis in which it cannot slide");
  }
}

Signal motor_input(const Scene& scene, const Motor& motor) {
  const Quantity& effort = kind_named(joint_named(scene, motor.joint).type).effort;
  return {.name = motor.name + "." + std::string(effort.name),
          .unit = std::string(effort.unit),
          .description = motor.name + ": " + std::string(effort.description) + ", driving joint " + motor.joint};
}

}  // namespace

std::vector<Signal> input_signals(const Scene& scene) {
  std::vector<Signal> signals;
  for (const Motor& motor : scene.motors) signals.push_back(motor_input(scene, motor));
  for (const Force& force : scene.forces) {
    if (force.type != ForceType::wrench || !force.input) continue;
    const std::string where =
        " on " + force.at.body + ", resolved in " + (force.in_body ? "the body" : std::string("the world"));
    add_array(signals, force.name, "f", 3, "N", "additional force" + where);
    add_array(signals, force.name, "t", 3, "N.m", "additional torque" + where);
  }
  for (const Constraint& c : scene.constraints) {
    if (c.type == ConstraintType::motion) add_motion_input(signals, scene, c);
  }
  return signals;
}

std::vector<Signal> output_signals(const Scene& scene) {
  std::vector<Signal> signals;
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    const JointKind& kind = kind_named(joint.type);
    add_level(signals, joint, static_cast<int>(j), 0, kind.q);
    add_level(signals, joint, static_cast<int>(j), 1, kind.v);
    add_level(signals, joint, static_cast<int>(j), 2, kind.a);
  }
  for (const Sensor& sensor : scene.sensors) {
    if (sensor.type == SensorType::reaction) add_reaction(signals, sensor);
    if (sensor.type == SensorType::frame) add_frame(signals, sensor);
    if (sensor.type == SensorType::energy) add_energy(signals, sensor);
  }
  for (const Constraint& c : scene.constraints) add_constraint(signals, scene, c);
  return signals;
}

std::vector<Signal> diagnostic_signals() {
  std::vector<Signal> signals(diagnostic_count);
  const auto set = [&signals](Diagnostic which, const char* name, const char* unit, const char* description) {
    Signal& s = signals[static_cast<std::size_t>(which)];
    s.name = name;
    s.unit = unit;
    s.description = description;
  };
  set(Diagnostic::constraint_position, "constraints.position", "1",
      "largest error of a constraint, as a loop's closure: metres for gaps, radians for angles");
  set(Diagnostic::constraint_velocity, "constraints.velocity", "1",
      "largest error of a constraint's rate: m/s for gaps, rad/s for angles");
  set(Diagnostic::kinetic_energy, "energy.kinetic", "J", "kinetic energy of the mechanism");
  set(Diagnostic::potential_energy, "energy.potential", "J", "potential energy of gravity, springs and stops");
  set(Diagnostic::total_energy, "energy.total", "J", "kinetic and potential energy together");
  set(Diagnostic::steps, "solver.steps", "1", "steps the integrator made since initialisation");
  set(Diagnostic::evaluations, "solver.evaluations", "1",
      "evaluations of the equations of motion since initialisation");
  set(Diagnostic::rejected_steps, "solver.rejected_steps", "1", "steps tried and given up since initialisation");
  set(Diagnostic::jacobians, "solver.jacobians", "1",
      "Jacobian matrices made for implicit methods since initialisation");
  set(Diagnostic::singular_positions, "solver.singular_positions", "1",
      "singular positions passed since initialisation, where loops could go on by another branch");
  return signals;
}

}  // namespace gelenk
