// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/properties.h"

#include <algorithm>
#include <cmath>

#include "joint/registry.h"
#include "scene/units.h"

namespace gelenk {
namespace {

constexpr const char* axis_names[] = {"x", "y", "z"};
constexpr double unbounded = std::numeric_limits<double>::infinity();

class Table {
 public:
  template <class Access>
  Parameter& add(const std::string& owner, const std::string& key, const std::string& name, std::string_view unit,
                 const std::string& description, Access access) {
    const std::string path = owner + "." + key;
    const std::string element = name.substr(std::min(name.find('['), name.size()));
    rows_.push_back({path, path + element,
                     real_parameter(owner + "." + name, unit, owner + ": " + description, std::move(access))});
    return rows_.back().parameter;
  }

  // As add(), of something that may change during a run; min: the least allowed.
  template <class Access>
  void add_tunable(const std::string& owner, const std::string& key, const std::string& name, std::string_view unit,
                   const std::string& description, double min, Access access) {
    Parameter& p = add(owner, key, name, unit, description, std::move(access));
    p.tunable = true;
    p.min = min;
  }

  // access(scene) gives a reference to a 3-vector.
  template <class Access>
  void add_vector(const std::string& owner, const std::string& key, std::string_view unit,
                  const std::string& description, Access access, bool tunable = false) {
    for (int i = 0; i < 3; ++i) {
      add(owner, key, key + "[" + std::to_string(i + 1) + "]", unit, description + ", " + axis_names[i] + " component",
          [access, i](auto& scene) -> auto& { return access(scene)[i]; })
          .tunable = tunable;
    }
  }

  std::vector<Property> take() { return std::move(rows_); }

 private:
  std::vector<Property> rows_;
};

void add_inertia(Table& table, const std::string& body, std::size_t b) {
  static constexpr int places[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
  for (int i = 0; i < 6; ++i) {
    const int r = places[i][0];
    const int c = places[i][1];
    Parameter& p = table.add(body, "inertia", "inertia[" + std::to_string(i + 1) + "]", "kg.m2",
                             std::string("inertia about the centre of mass, ") + axis_names[r] + axis_names[c],
                             [=](auto& scene) -> auto& { return scene.bodies[b].inertia(r, c); });
    p.put = [=](Scene& scene, double value) {
      scene.bodies[b].inertia(r, c) = value;
      scene.bodies[b].inertia(c, r) = value;
    };
    if (r == c) p.min = 0;
  }
}

void add_body(Table& table, const std::string& body, std::size_t b) {
  table.add(body, "mass", "m", "kg", "mass", [b](auto& scene) -> auto& { return scene.bodies[b].mass; }).min = 0;
  table.add_vector(body, "com", "m", "centre of mass in the body's frame",
                   [b](auto& scene) -> auto& { return scene.bodies[b].com; });
  add_inertia(table, body, b);
}

// "rad" -> "N.m", "m" -> "N".
std::string effort_unit(std::string_view coordinate_unit) { return coordinate_unit == "rad" ? "N.m" : "N"; }

void add_spring(Table& table, const Joint& joint, const JointKind& kind, std::size_t j, std::size_t i) {
  const std::string element = kind.nv == 1 ? "" : "[" + std::to_string(i + 1) + "]";
  const std::string_view unit = kind.q[i].unit;
  const std::string on = " on " + std::string(kind.q[i].name);
  const std::string effort = effort_unit(unit);
  table.add_tunable(joint.name, "stiffness", "stiffness" + element, effort + "/" + std::string(unit), "stiffness" + on,
                    0, [=](auto& scene) -> auto& { return scene.joints[j].stiffness[i]; });
  table.add_tunable(joint.name, "spring_reference", "spring_reference" + element, unit,
                    "where the spring is slack, " + std::string(kind.q[i].name), -unbounded,
                    [=](auto& scene) -> auto& { return scene.joints[j].spring_reference[i]; });
}

void add_stop(Table& table, const Joint& joint, const JointKind& kind, std::size_t j) {
  const std::string unit(kind.q[0].unit);
  const std::string effort = effort_unit(unit);
  const std::string q(kind.q[0].name);
  const auto add = [&](const std::string& key, const std::string& in, const std::string& what,
                       double Stop::* field) -> Parameter& {
    return table.add(joint.name, "stop." + key, "stop." + key, in, what + " of its stop, on " + q,
                     [=](auto& scene) -> auto& { return (*scene.joints[j].stop).*field; });
  };
  const auto add_tunable = [&](const std::string& key, const std::string& in, double Stop::* field) {
    Parameter& p = add(key, in, key, field);
    p.tunable = true;
    p.min = 0;
  };
  if (std::isfinite(joint.stop->lower)) add("lower", unit, "lower bound", &Stop::lower);
  if (std::isfinite(joint.stop->upper)) add("upper", unit, "upper bound", &Stop::upper);
  add_tunable("stiffness", effort + "/" + unit, &Stop::stiffness);
  add_tunable("damping", effort + (unit == "rad" ? ".s/rad" : ".s/m"), &Stop::damping);
}

void add_joint(Table& table, const Joint& joint, std::size_t j) {
  const JointKind* kind = find_joint_kind(joint.type);
  if (kind == nullptr) return;
  for (std::size_t i = 0; i < kind->v.size(); ++i) {
    const std::string element = kind->nv == 1 ? "" : "[" + std::to_string(i + 1) + "]";
    const std::string unit = kind->v[i].unit == "rad/s" ? "N.m.s/rad" : "N.s/m";
    table.add_tunable(joint.name, "damping", "damping" + element, unit, "damping on " + std::string(kind->v[i].name), 0,
                      [=](auto& scene) -> auto& { return scene.joints[j].damping[i]; });
    if (kind->springs()) add_spring(table, joint, *kind, j, i);
  }
  if (joint.stop) add_stop(table, joint, *kind, j);
  table.add_vector(joint.name, "parent.position", "m", "position of its frame in " + joint.parent.body,
                   [j](auto& scene) -> auto& { return scene.joints[j].parent.X_BF.p; });
  table.add_vector(joint.name, "child.position", "m", "position of its frame in " + joint.child.body,
                   [j](auto& scene) -> auto& { return scene.joints[j].child.X_BF.p; });
}

void add_motor(Table& table, const Scene& scene, std::size_t m) {
  const Motor& motor = scene.motors[m];
  const auto joint = std::ranges::find(scene.joints, motor.joint, &Joint::name);
  const JointKind* kind = joint == scene.joints.end() ? nullptr : find_joint_kind(joint->type);
  const bool turns = kind == nullptr || kind->effort.unit == "N.m";
  table.add(motor.name, "gear_ratio", "gear_ratio", "1", "travel of the motor per travel of joint " + motor.joint,
            [m](auto& s) -> auto& { return s.motors[m].gear_ratio; });
  table
      .add(motor.name, "rotor_inertia", "rotor_inertia", turns ? "kg.m2" : "kg", "inertia at the motor side",
           [m](auto& s) -> auto& { return s.motors[m].rotor_inertia; })
      .min = 0;
}

void add_force(Table& table, const Force& force, std::size_t f) {
  if (force.type == ForceType::wrench) {
    const auto add = [&](const char* key, const char* unit, const char* what, Eigen::Vector3d Force::* field) {
      table.add_vector(force.name, key, unit, what, [=](auto& s) -> auto& { return s.forces[f].*field; }, true);
    };
    add("force", "N", "constant force", &Force::force);
    add("torque", "N.m", "constant torque", &Force::torque);
    return;
  }
  const auto add = [&](const char* key, const char* unit, const char* what, double Force::* field) {
    table.add_tunable(force.name, key, key, unit, what, 0, [=](auto& s) -> auto& { return s.forces[f].*field; });
  };
  add("stiffness", "N/m", "stiffness", &Force::stiffness);
  add("damping", "N.s/m", "damping", &Force::damping);
  add("length", "m", "free length", &Force::length);
}

void add_motion(Table& table, const Scene& scene, std::size_t c) {
  const Constraint& constraint = scene.constraints[c];
  const std::string& name = constraint.name;
  const auto joint = std::ranges::find(scene.joints, constraint.joint, &Joint::name);
  const JointKind* kind = joint == scene.joints.end() ? nullptr : find_joint_kind(joint->type);
  if (kind == nullptr) return;
  const auto q = static_cast<std::size_t>(motion_signals(*kind, constraint).component);
  const auto add = [&](const char* key, std::string_view unit, const char* what, double GivenMotion::* field) {
    table.add(name, key, key, unit, what, [=](auto& s) -> auto& { return s.constraints[c].motion.*field; });
  };
  if (constraint.motion.source == GivenMotion::Source::speed) {
    add("speed", kind->v[q].unit, "constant speed", &GivenMotion::speed);
  }
  if (constraint.motion.source != GivenMotion::Source::function) return;
  for (std::size_t i = 0; i < constraint.motion.polynomial.size(); ++i) {
    table.add(name, "polynomial", "polynomial[" + std::to_string(i + 1) + "]", i == 0 ? kind->q[q].unit : "",
              "coefficient of t^" + std::to_string(i),
              [=](auto& s) -> auto& { return s.constraints[c].motion.polynomial[i]; });
  }
  if (!has_sine(constraint.motion)) return;
  add("sine.amplitude", kind->q[q].unit, "amplitude", &GivenMotion::amplitude);
  add("sine.frequency", "Hz", "frequency", &GivenMotion::frequency);
  add("sine.phase", "rad", "phase at t = 0", &GivenMotion::phase);
}

void add_constraint(Table& table, const Scene& scene, std::size_t c) {
  const Constraint& constraint = scene.constraints[c];
  const std::string& name = constraint.name;
  const auto ratio = [c](auto& s) -> auto& { return s.constraints[c].ratio; };
  const auto offset = [c](auto& s) -> auto& { return s.constraints[c].offset; };
  switch (constraint.type) {
    case ConstraintType::motion:
      return add_motion(table, scene, c);
    case ConstraintType::gear:
      table.add(name, "ratio", "ratio", "1", "turns of the first joint for a turn of the other", ratio);
      table.add(name, "offset", "offset", "rad", "angle of the first joint where the other is at 0", offset);
      return;
    case ConstraintType::rack:
      table.add(name, "radius", "radius", "m", "travel of the rack for a radian of the pinion", ratio);
      table.add(name, "offset", "offset", "m", "position of the rack where the pinion is at 0", offset);
      return;
    case ConstraintType::rolling:
      table
          .add(name, "radius", "radius", "m", "radius of the wheel",
               [c](auto& s) -> auto& { return s.constraints[c].radius; })
          .min = 0;
      return;
    case ConstraintType::knife_edge:
      return;
  }
}

}  // namespace

std::vector<Property> scene_properties(const Scene& scene) {
  Table table;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) add_body(table, scene.bodies[b].name, b);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) add_joint(table, scene.joints[j], j);
  for (std::size_t m = 0; m < scene.motors.size(); ++m) add_motor(table, scene, m);
  for (std::size_t f = 0; f < scene.forces.size(); ++f) add_force(table, scene.forces[f], f);
  for (std::size_t c = 0; c < scene.constraints.size(); ++c) add_constraint(table, scene, c);
  return table.take();
}

}  // namespace gelenk
