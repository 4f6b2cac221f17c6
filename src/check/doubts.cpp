// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "check/doubts.h"
#include "joint/registry.h"
#include "scene/element_numbers.h"
#include "scene/units.h"
#include "util/text.h"

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

void doubt_start(const Joint& joint, const JointKind& kind, const std::string& path, Faults& faults) {
  for (const QuantityGroup& group : groups(kind.q)) {
    if (group.array || group.unit != "rad" || !joint.start.q_given[group.first]) continue;
    doubt_angle(joint.start.q[group.first], path + ".start." + group.name, faults);
  }
}

// Of an element's numbers those in rad; of a list the first.
void doubt_numbers(std::span<const Field> fields, const void* element, const Coordinate& coordinate,
                   const std::string& path, Faults& faults, const std::string& index = {}) {
  const Field* doubted = nullptr;
  each_number(fields, element, [&](const Number& x) {
    if (x.unit(coordinate) != "rad" || x.field == doubted || !looks_like_degrees(*x.value)) return;
    doubted = x.field;
    doubt_angle(*x.value, path + "." + x.path() + x.index() + index, faults);
  });
}

void doubt_forces(const Joint& joint, const JointKind& kind, const std::string& path, Faults& faults) {
  for (const JointForceKind& force : joint_force_kinds()) {
    for (int i = 0; i < kind.nv; ++i) {
      const void* there = force.fits(kind) ? force.in(joint.along[i]) : nullptr;
      const std::string group = force.group.empty() ? "" : "." + std::string(force.group);
      if (there == nullptr) continue;
      const Coordinate coordinate = coordinate_of(kind, i);
      const std::string index = kind.nv > 1 ? "[" + std::to_string(i + 1) + "]" : "";
      doubt_numbers(force.fields, there, coordinate, path + group, faults, index);
      if (!kind.springs() || !joint.start.q_given[i]) continue;
      const auto doubt = force.doubt(there, joint.start.q[i], coordinate);
      if (doubt) faults.doubt(path + ".start." + std::string(coordinate.name), doubt->found, doubt->expected);
    }
  }
}

void doubt_motors(const Scene& scene, Faults& faults) {
  std::map<std::string, std::string> drives;
  for (const Motor& motor : scene.motors) {
    const std::string& joint = motor.joints.front();
    const auto [first, alone] = drives.try_emplace(joint, motor.name);
    if (alone) continue;
    faults.doubt("motors." + motor.name + ".joint", text::quoted(joint) + ", which '" + first->second + "' drives",
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
    doubt_forces(joint, *kind, path, faults);
  }
  doubt_names(scene, faults);
  doubt_motors(scene, faults);
  each_section(scene, [&](const Section& section, const auto& elements) {
    for (const auto& element : elements) {
      doubt_numbers(kind_of(element.is).fields, data_of(element.is), coordinate_of(scene, element),
                    std::string(section.name) + "." + element.name, faults);
    }
  });
}

std::vector<std::string> find_doubts(const Scene& scene) {
  Faults faults(scene.file);
  find_doubts(scene, faults);
  return faults.doubts();
}

}  // namespace gelenk
