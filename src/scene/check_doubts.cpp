// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "joint/registry.h"
#include "scene/doubts.h"
#include "scene/text.h"
#include "scene/units.h"

namespace gelenk {
namespace {

constexpr double pi = std::numbers::pi;

// Large for radians and with few digits, as people write degrees. What a program computed has many digits; what
// people compute are mostly parts of a turn.
bool looks_like_degrees(double x) {
  constexpr double least = 10;  // rad, more than one and a half turns
  constexpr double most = 3600;
  if (!(std::abs(x) >= least && std::abs(x) <= most)) return false;
  if (x == std::round(x)) return true;
  const double thousandths = 1000 * x;
  if (std::abs(thousandths - std::round(thousandths)) > 1e-9 * std::abs(thousandths)) return false;  // rounding of x
  constexpr double one_decimal = 0.05;  // 31.4 stands for five turns
  return std::abs(std::remainder(x, pi / 2)) > one_decimal;
}

void doubt_angles(const std::vector<double>& angles, const std::string& path, Faults& faults) {
  const auto found = std::ranges::find_if(angles, looks_like_degrees);
  if (found == angles.end()) return;
  const std::string index = angles.size() == 1 ? "" : "[" + std::to_string(found - angles.begin() + 1) + "]";
  doubt_angle(*found, path + index, faults);
}

void doubt_start(const Joint& joint, const JointKind& kind, const std::string& path, Faults& faults) {
  for (const QuantityGroup& group : groups(kind.q)) {
    if (group.array || group.unit != "rad" || !joint.start.q_given[group.first]) continue;
    doubt_angle(joint.start.q[group.first], path + ".start." + group.name, faults);
  }
}

// Angles of a joint's spring and stop.
void doubt_references(const Joint& joint, const JointKind& kind, const std::string& path, Faults& faults) {
  if (!kind.springs() || kind.q[0].unit != "rad") return;
  const bool all_turn = std::ranges::all_of(kind.q, [](const Quantity& q) { return q.unit == "rad"; });
  if (all_turn) doubt_angles(joint.spring_reference, path + ".spring_reference", faults);
  if (!joint.stop) return;
  doubt_angle(joint.stop->lower, path + ".stop.lower", faults);
  doubt_angle(joint.stop->upper, path + ".stop.upper", faults);
}

// It may be meant: what rests on a stop has pressed it in.
void doubt_stop(const Joint& joint, const JointKind& kind, const std::string& path, Faults& faults) {
  if (!joint.stop || !kind.stops() || !joint.start.q_given[0]) return;
  const Stop& stop = *joint.stop;
  const double q = joint.start.q[0];
  const double depth = std::max(stop.lower - q, q - stop.upper);
  if (!(depth > 0)) return;
  const bool above = q > stop.upper;
  const JointUnits units = joint_units(kind);
  const std::string effort = units.coordinate == "rad" ? "N m" : "N";
  const auto number = [&](double x) { return text::with_unit(text::rounded(x), units.coordinate); };
  faults.doubt(path + ".start." + std::string(kind.q[0].name), number(q),
               std::string(above ? "at most stop.upper = " : "at least stop.lower = ") +
                   number(above ? stop.upper : stop.lower) + "; " + number(depth) +
                   " beyond it, the stop pushes with " + text::rounded(stop.stiffness * depth, 3) + " " + effort);
}

void doubt_motors(const Scene& scene, Faults& faults) {
  std::map<std::string, std::string> drives;
  for (const Motor& motor : scene.motors) {
    const auto [first, alone] = drives.try_emplace(motor.joint, motor.name);
    if (alone) continue;
    faults.doubt("motors." + motor.name + ".joint",
                 text::quoted(motor.joint) + ", which '" + first->second + "' drives",
                 "one motor at a joint; where two are meant, what they apply adds up");
  }
}

void doubt_names(const Scene& scene, Faults& faults) {
  std::map<std::string, const Joint*> joints;
  for (const Joint& joint : scene.joints) joints.try_emplace(joint.name, &joint);
  for (const Body& body : scene.bodies) {
    if (!joints.contains(body.name)) continue;
    faults.doubt("joints." + body.name, "the name of a body",
                 "another; " + body.name + ".mass will be of the body, " + body.name + ".damping of the joint");
  }
}

void doubt_motion(const Scene& scene, const Constraint& constraint, const std::string& path, Faults& faults) {
  const auto joint = std::ranges::find(scene.joints, constraint.joint, &Joint::name);
  const JointKind* kind = joint == scene.joints.end() ? nullptr : find_joint_kind(joint->type);
  if (kind == nullptr) return;
  const GivenMotion& motion = constraint.motion;
  doubt_angle(motion.phase, path + ".sine.phase", faults);
  const auto coordinate = std::ranges::find(kind->q, constraint.coordinate, &Quantity::name);
  if (coordinate == kind->q.end() || coordinate->unit != "rad") return;
  doubt_angle(motion.amplitude, path + ".sine.amplitude", faults);
  if (!motion.polynomial.empty()) doubt_angle(motion.polynomial[0], path + ".polynomial[1]", faults);
  doubt_angles(motion.values, path + ".table.value", faults);
}

}  // namespace

void doubt_angle(double angle, const std::string& path, Faults& faults) {
  if (!looks_like_degrees(angle)) return;
  const std::string shown = text::number(angle);
  faults.doubt(path, shown + " rad, which is " + text::rounded(angle / (2 * pi), 3) + " turns",
               "an angle in rad; " + shown + " degrees are " + text::rounded(angle * pi / 180) + " rad");
}

void find_doubts(const Scene& scene, Faults& faults) {
  for (const Joint& joint : scene.joints) {
    const JointKind* kind = find_joint_kind(joint.type);
    if (kind == nullptr) continue;
    const std::string path = "joints." + joint.name;
    doubt_start(joint, *kind, path, faults);
    doubt_references(joint, *kind, path, faults);
    doubt_stop(joint, *kind, path, faults);
  }
  doubt_names(scene, faults);
  doubt_motors(scene, faults);
  for (const Constraint& constraint : scene.constraints) {
    const std::string path = "constraints." + constraint.name;
    if (constraint.type == ConstraintType::motion) doubt_motion(scene, constraint, path, faults);
    if (constraint.type == ConstraintType::gear) doubt_angle(constraint.offset, path + ".offset", faults);
  }
}

std::vector<std::string> find_doubts(const Scene& scene) {
  Faults faults(scene.file);
  find_doubts(scene, faults);
  return faults.doubts();
}

}  // namespace gelenk
