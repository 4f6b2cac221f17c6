// SPDX-License-Identifier: BSD-3-Clause
#include "modelDescription/units.h"

#include <algorithm>
#include <iterator>
#include <numbers>

namespace gelenk {
namespace {

struct Measured {
  std::string_view unit, quantity;
};
constexpr Measured quantities[] = {
    {"rad", "Angle"},
    {"rad/s", "AngularVelocity"},
    {"rad/s2", "AngularAcceleration"},
    {"m", "Length"},
    {"m/s", "Velocity"},
    {"m/s2", "Acceleration"},
    {"N", "Force"},
    {"N.m", "Torque"},
    {"kg", "Mass"},
    {"kg.m2", "MomentOfInertia"},
    {"J", "Energy"},
    {"W", "Power"},
    {"s", "Time"},
    {"Hz", "Frequency"},
    {"N/m", "TranslationalSpringConstant"},
    {"N.m/rad", "RotationalSpringConstant"},
    {"N.s/m", "TranslationalDampingConstant"},
    {"N.m.s/rad", "RotationalDampingConstant"},
};

constexpr double degrees = 180 / std::numbers::pi;
constexpr DisplayUnit angle[] = {{"deg", degrees}};
constexpr DisplayUnit speed[] = {{"rpm", 30 / std::numbers::pi}, {"deg/s", degrees}};
constexpr DisplayUnit acceleration[] = {{"deg/s2", degrees}};

}  // namespace

std::string_view quantity(std::string_view unit) {
  const auto* const found = std::ranges::find(quantities, unit, &Measured::unit);
  return found == std::end(quantities) ? std::string_view() : found->quantity;
}

std::span<const DisplayUnit> display_units(std::string_view unit) {
  if (unit == "rad") return angle;
  if (unit == "rad/s") return speed;
  if (unit == "rad/s2") return acceleration;
  return {};
}

std::string default_display_unit(std::string_view unit) {
  const auto others = display_units(unit);
  return others.empty() ? std::string() : others.front().name;
}

}  // namespace gelenk
