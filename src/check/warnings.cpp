// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include "check/warnings.h"
#include "joint/kinds.h"
#include "scene/element_numbers.h"
#include "scene/quantity_groups.h"
#include "util/text.h"

namespace gelenk {
namespace {

constexpr double pi = std::numbers::pi;

// Recognizes angles given in degrees: large for radians and with few digits. Angles computed by a program have many
// digits, and those computed by hand are mostly fractions of a turn.
bool looks_like_degrees(double x) {
  constexpr double min_angle = 10;    // rad, more than one and a half turns
  constexpr double max_angle = 3600;  // rad if read as such, ten turns in degrees
  if (!(std::abs(x) >= min_angle && std::abs(x) <= max_angle)) return false;
  if (x == std::round(x)) return true;
  const double thousandths = 1000 * x;
  if (std::abs(thousandths - std::round(thousandths)) > 1e-9 * std::abs(thousandths)) return false;  // rounding of x
  constexpr double one_decimal = 0.05;  // rad; 31.4 is five turns rounded to one decimal
  return std::abs(std::remainder(x, pi / 2)) > one_decimal;
}

void warn_about_start(const Joint& joint, const JointKind& kind, const std::string& path, Faults& faults) {
  for (const QuantityGroup& group : groups(kind.q)) {
    if (group.array || group.unit != "rad" || !joint.start.q_given[group.first]) continue;
    warn_about_angle(joint.start.q[group.first], path + ".start." + group.name, faults);
  }
}

// Checks the numbers of an element that are in rad; at most one warning per field.
void warn_about_numbers(std::span<const Field> fields, const void* element, const Coordinate& coordinate,
                        const std::string& path, Faults& faults, const std::string& index = {}) {
  const Field* reported = nullptr;
  each_number(fields, element, [&](const Number& x) {
    if (x.unit(coordinate) != "rad" || x.field == reported || !looks_like_degrees(*x.value)) return;
    reported = x.field;
    warn_about_angle(*x.value, path + "." + x.path() + x.index() + index, faults);
  });
}

void warn_about_forces(const Joint& joint, const JointKind& kind, const std::string& path, Faults& faults) {
  for (const JointForceKind& force : joint_force_kinds()) {
    for (int i = 0; i < kind.nv; ++i) {
      const void* there = force.fits(kind) ? force.in(*joint.along[i]) : nullptr;
      if (there == nullptr) continue;
      const Coordinate coordinate = coordinate_of(kind, i);
      const std::string group = group_along(force.group, kind, i);
      const std::string at = group.empty() ? path : path + "." + group;
      const std::string index = group.empty() && kind.nv > 1 ? "[" + std::to_string(i + 1) + "]" : "";
      warn_about_numbers(force.fields, there, coordinate, at, faults, index);
      if (!kind.springs() || !joint.start.q_given[i]) continue;
      const auto warning = force.doubt(there, joint.start.q[i], coordinate);
      if (warning) faults.warn(path + ".start." + std::string(coordinate.name), warning->found, warning->expected);
    }
  }
}

void warn_about_motors(const Scene& scene, Faults& faults) {
  std::map<std::string, std::string> drives;
  for (const Motor& motor : scene.motors) {
    const std::string& joint = motor.joints.front();
    const auto [first, alone] = drives.try_emplace(joint + "." + motor.coordinate, motor.name);
    if (alone) continue;
    faults.warn("motors." + motor.name + ".joint", text::quoted(joint) + ", already driven by '" + first->second + "'",
                "one motor per joint; if both are intended, their torques or forces add up");
  }
}

void warn_about_tables(const Scene& scene, Faults& faults) {
  for (const SceneTable& table : scene.tables) {
    const std::string overshoot = table.is->doubt();
    if (!overshoot.empty()) faults.warn("tables." + table.name, overshoot, "interpolation: pchip, or more points");
  }
}

// Gravity of the Earth in millimeters is a thousand times too large.
void warn_about_gravity(const Scene& scene, Faults& faults) {
  constexpr double max_gravity = 500;  // m/s2; at the surface of the Sun, 274
  const double g = scene.gravity.norm();
  if (!(g > max_gravity)) return;
  const std::string found = text::rounded(g);
  faults.warn(
      "gravity", found + " m/s2",
      "at most " + text::number(max_gravity) + " m/s2; " + found + " mm/s2 are " + text::rounded(g / 1000) + " m/s2");
}

}  // namespace

void warn_about_angle(double angle, const std::string& path, Faults& faults) {
  constexpr double max_angle = 1e6;  // rad: 160,000 turns, of which rounding leaves 1e-10 rad
  if (std::abs(angle) > max_angle) {
    faults.warn(path, text::rounded(angle) + " rad, which is " + text::rounded(angle / (2 * pi), 3) + " turns",
                "an angle in rad of at most " + text::number(max_angle) + " rad");
    return;
  }
  if (!looks_like_degrees(angle)) return;
  const std::string shown = text::number(angle);
  faults.warn(path, shown + " rad, which is " + text::rounded(angle / (2 * pi), 3) + " turns",
              "an angle in rad; " + shown + " degrees are " + text::rounded(angle * pi / 180) + " rad");
}

void find_warnings(const Scene& scene, Faults& faults) {
  for (const Joint& joint : scene.joints) {
    const JointKind* kind = find_joint_kind(joint.type);
    if (kind == nullptr) continue;
    const std::string path = "joints." + joint.name;
    warn_about_start(joint, *kind, path, faults);
    warn_about_forces(joint, *kind, path, faults);
  }
  warn_about_gravity(scene, faults);
  warn_about_tables(scene, faults);
  warn_about_sizes(scene, faults);
  warn_about_motors(scene, faults);
  each_section(scene, [&](const Section& section, const auto& elements) {
    for (const auto& element : elements) {
      warn_about_numbers(kind_of(*element.is).fields, data_of(*element.is), coordinate_of(scene, element),
                         std::string(section.name) + "." + element.name, faults);
      if (const auto doubt = doubt_of(*element.is)) {
        faults.warn(std::string(section.name) + "." + element.name + "." + doubt->field, doubt->found, doubt->expected);
      }
    }
  });
}

std::vector<std::string> find_warnings(const Scene& scene) {
  Faults faults(scene.file);
  find_warnings(scene, faults);
  return faults.warnings();
}

}  // namespace gelenk
