// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "joint/registry.h"
#include "scene/json_tree.h"
#include "scene/read.h"
#include "scene/units.h"
#include "scene/words.h"

namespace gelenk {
namespace {

template <class Numbers>
Json list(const Numbers& numbers) {
  Json out = Json::array();
  for (const double x : numbers) out.push_back(x);
  return out;
}

// A rotation goes out as its nine numbers: reading leaves a matrix that is one to rounding as it is.
void add_pose(Json& out, const Pose3& X) {
  out["position"] = list(X.p);
  if ((X.R.array() == Eigen::Matrix3d::Identity().array()).all()) return;
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) rows.push_back(list(Eigen::RowVector3d(X.R.row(i))));
  out["rotation"]["matrix"] = rows;
}

Json frame(const BodyFrame& frame) {
  Json out;
  out["body"] = frame.body;
  add_pose(out, frame.X_BF);
  return out;
}

Json point(const BodyFrame& frame) {
  Json out;
  out["body"] = frame.body;
  out["position"] = list(frame.X_BF.p);
  return out;
}

Json body(const Body& body) {
  const Eigen::Matrix3d& I = body.inertia;
  Json out;
  out["mass"] = body.mass;
  out["com"] = list(body.com);
  out["inertia"] = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
  if (body.pose) {
    out["pose"] = Json::object();
    add_pose(out["pose"], *body.pose);
  }
  return out;
}

// The groups of coordinates or speeds of which a value is given.
void add_start_values(Json& out, Json& fixed, std::span<const Quantity> quantities, const std::vector<double>& values,
                      const std::vector<bool>& given, const std::vector<bool>& held) {
  for (const QuantityGroup& group : groups(quantities)) {
    const auto any = [&](const std::vector<bool>& flags) {
      const auto first = flags.begin() + static_cast<std::ptrdiff_t>(group.first);
      return std::any_of(first, first + static_cast<std::ptrdiff_t>(group.size), [](bool flag) { return flag; });
    };
    if (!any(given) && !any(held)) continue;
    const double* first = values.data() + group.first;
    out[group.name] = group.array ? list(std::span(first, group.size)) : Json(*first);
    if (any(held)) fixed.push_back(group.name);
  }
}

// Weights that are not as if nothing were said, by name.
void add_weights(Json& out, std::span<const Quantity> quantities, const std::vector<bool>& given,
                 const std::vector<double>& weights) {
  for (const QuantityGroup& group : groups(quantities)) {
    const double weight = weights.at(group.first);
    if (given.at(group.first) && weight != default_start_weight) out[group.name] = weight;
  }
}

Json start(const JointStart& start, const JointKind& kind) {
  Json out = Json::object();
  Json fixed = Json::array();
  add_start_values(out, fixed, kind.q, start.q, start.q_given, start.q_fixed);
  add_start_values(out, fixed, kind.v, start.v, start.v_given, start.v_fixed);
  if (!fixed.empty()) out["fixed"] = fixed.size() == out.size() ? Json(true) : fixed;
  Json weights = Json::object();
  add_weights(weights, kind.q, start.q_given, start.q_weight);
  add_weights(weights, kind.v, start.v_given, start.v_weight);
  if (!weights.empty()) out["weight"] = std::move(weights);
  return out;
}

Json stop(const Stop& stop) {
  Json out;
  if (std::isfinite(stop.lower)) out["lower"] = stop.lower;
  if (std::isfinite(stop.upper)) out["upper"] = stop.upper;
  out["stiffness"] = stop.stiffness;
  out["damping"] = stop.damping;
  return out;
}

Json joint(const Joint& joint) {
  Json out;
  out["type"] = joint.type;
  if (joint.axes.size() == 1) out["axis"] = list(joint.axes[0]);
  if (joint.axes.size() == 2) out["axes"] = {list(joint.axes[0]), list(joint.axes[1])};
  out["parent"] = frame(joint.parent);
  out["child"] = frame(joint.child);
  const JointKind* kind = find_joint_kind(joint.type);
  if (kind == nullptr || kind->nv == 0) return out;
  Json values = start(joint.start, *kind);
  if (!values.empty()) out["start"] = std::move(values);
  const auto per_speed = [&](const std::vector<double>& x) { return kind->nv == 1 ? Json(x.at(0)) : list(x); };
  out["damping"] = per_speed(joint.damping);
  if (!kind->springs()) return out;
  out["stiffness"] = per_speed(joint.stiffness);
  out["spring_reference"] = per_speed(joint.spring_reference);
  if (joint.stop) out["stop"] = stop(*joint.stop);
  return out;
}

Json motor(const Motor& motor) {
  return {{"joint", motor.joint}, {"gear_ratio", motor.gear_ratio}, {"rotor_inertia", motor.rotor_inertia}};
}

Json force(const Force& force) {
  Json out;
  if (force.type == ForceType::spring_damper) {
    out["type"] = "spring_damper";
    out["from"] = point(force.from);
    out["to"] = point(force.to);
    out["stiffness"] = force.stiffness;
    out["damping"] = force.damping;
    out["length"] = force.length;
    return out;
  }
  out["type"] = "wrench";
  out.update(frame(force.at));
  out["force"] = list(force.force);
  out["torque"] = list(force.torque);
  out["frame"] = force.in_body ? "body" : "world";
  out["input"] = force.input;
  return out;
}

Json motion(const Constraint& constraint) {
  const GivenMotion& m = constraint.motion;
  Json out = {{"type", "motion"}, {"joint", constraint.joint}, {"coordinate", constraint.coordinate}};
  using Source = GivenMotion::Source;
  switch (m.source) {
    case Source::function:
      if (!m.polynomial.empty()) out["polynomial"] = list(m.polynomial);
      if (has_sine(m)) {
        out["sine"] = {{"amplitude", m.amplitude}, {"frequency", m.frequency}, {"phase", m.phase}};
      }
      break;
    case Source::table:
      out["table"] = {{"time", list(m.times)}, {"value", list(m.values)}, {"periodic", m.periodic}};
      break;
    case Source::speed:
      out["speed"] = m.speed;
      break;
    case Source::input:
    case Source::input_speed:
      out["input"] = words::motion_inputs[m.source == Source::input ? 0 : 1];
      break;
  }
  return out;
}

Json constraint(const Constraint& c) {
  Json out = {{"type", words::constraints[static_cast<std::size_t>(c.type)]}};
  switch (c.type) {
    case ConstraintType::motion:
      return motion(c);
    case ConstraintType::gear:
      out.update({{"joint", c.joint}, {"with", c.other}, {"ratio", c.ratio}, {"offset", c.offset}});
      if (!c.carrier.empty()) out["carrier"] = c.carrier;
      return out;
    case ConstraintType::rack:
      out.update({{"rack", c.joint}, {"pinion", c.other}, {"radius", c.ratio}, {"offset", c.offset}});
      return out;
    case ConstraintType::rolling:
    case ConstraintType::knife_edge:
      break;
  }
  out.update(frame(c.at));
  out["axis"] = list(c.axis);
  out["on"] = frame(c.on);
  if (c.type == ConstraintType::rolling) out["radius"] = c.radius;
  return out;
}

Json sensor(const Sensor& sensor) {
  switch (sensor.type) {
    case SensorType::reaction:
      return {{"type", "reaction"}, {"joint", sensor.joint}};
    case SensorType::energy:
      return {{"type", "energy"}};
    case SensorType::frame:
      break;
  }
  Json out;
  out["type"] = "frame";
  out.update(frame(sensor.frame));
  return out;
}

template <class Element>
Json section(const std::vector<Element>& elements, Json (*write)(const Element&)) {
  Json out = Json::object();
  for (const Element& element : elements) out[element.name] = write(element);
  return out;
}

// One line for each entry of a section: short, and still to be read and compared by people.
std::string laid_out(const Json& tree) {
  std::string out = "{";
  const char* separator = "\n ";
  for (const auto& [key, value] : tree.items()) {
    out += separator + Json(key).dump() + ": ";
    separator = ",\n ";
    const bool entries = value.is_object() && !value.empty() && value.front().is_object();
    if (!entries) {
      out += value.dump();
      continue;
    }
    const char* inner = "{\n  ";
    for (const auto& [name, entry] : value.items()) {
      out += inner + Json(name).dump() + ": " + entry.dump();
      inner = ",\n  ";
    }
    out += "\n }";
  }
  return out + "\n}\n";
}

}  // namespace

std::string write_scene_json(const Scene& scene) {
  Json out;
  out["gelenk"] = scene_version;
  out["name"] = scene.name;
  out["gravity"] = list(scene.gravity);
  out["bodies"] = section(scene.bodies, body);
  out["joints"] = section(scene.joints, joint);
  out["motors"] = section(scene.motors, motor);
  out["forces"] = section(scene.forces, force);
  if (!scene.constraints.empty()) out["constraints"] = section(scene.constraints, constraint);
  out["sensors"] = section(scene.sensors, sensor);
  out["parameters"] = scene.parameters;
  if (!scene.outputs.empty()) out["outputs"] = scene.outputs;
  if (scene.assembly.tolerance > 0) out["assembly"] = {{"tolerance", scene.assembly.tolerance}};
  const Experiment& e = scene.experiment;
  out["experiment"] = {{"stop", e.stop}, {"step", e.step}, {"tolerance", e.tolerance}};
  const Solver& s = scene.solver;
  out["solver"] = {{"formulation", s.formulation}, {"integrator", s.integrator}, {"step", s.step}};
  if (s.start != Solver{}.start) out["solver"]["start"] = s.start;
  if (s.max_evaluations != Solver{}.max_evaluations) out["solver"]["max_evaluations"] = s.max_evaluations;
  if (s.corrections != Solver{}.corrections) out["solver"]["corrections"] = s.corrections;
  if (s.rho_inf != Solver{}.rho_inf) out["solver"]["rho_inf"] = s.rho_inf;
  if (s.baumgarte_alpha != 0) out["solver"]["baumgarte_alpha"] = s.baumgarte_alpha;
  if (s.baumgarte_beta != 0) out["solver"]["baumgarte_beta"] = s.baumgarte_beta;
  if (const auto& l = scene.left_out) {
    out["solver"]["left_out"] = {{"length", l->length}, {"travel", l->travel}, {"mass", l->mass}};
  }
  for (int i = 0; i < reduction_count; ++i) {
    if (!s.reductions[i]) out["solver"]["reductions"][words::reductions[i]] = false;
  }
  return laid_out(out);
}

}  // namespace gelenk
