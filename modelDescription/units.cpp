// SPDX-License-Identifier: BSD-3-Clause
#include "modelDescription/units.h"

#include <algorithm>
#include <iterator>
#include <numbers>
#include <stdexcept>

namespace gelenk {
namespace {

struct Symbol {
  std::string_view name;
  UnitExponents exponents;  // kg, m, s, rad
};

constexpr Symbol symbols[] = {
    {"1", {0, 0, 0, 0}},   {"kg", {1, 0, 0, 0}}, {"m", {0, 1, 0, 0}},  {"s", {0, 0, 1, 0}},
    {"rad", {0, 0, 0, 1}}, {"N", {1, 1, -2, 0}}, {"J", {1, 2, -2, 0}}, {"Hz", {0, 0, -1, 0}},
};

// A symbol with an optional exponent: "m2".
UnitExponents factor(std::string_view text) {
  int power = 1;
  if (text.size() > 1 && text.back() >= '2' && text.back() <= '9') {
    power = text.back() - '0';
    text.remove_suffix(1);
  }
  for (const Symbol& symbol : symbols) {
    if (symbol.name != text) continue;
    UnitExponents exponents = symbol.exponents;
    for (int& e : exponents) e *= power;
    return exponents;
  }
  throw std::invalid_argument("no unit is called '" + std::string(text) + "'");
}

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

UnitExponents unit_exponents(std::string_view unit) {
  UnitExponents total{};
  int sign = 1;
  std::size_t begin = 0;
  while (begin <= unit.size()) {
    const std::size_t end = std::min(unit.find_first_of("./", begin), unit.size());
    const UnitExponents part = factor(unit.substr(begin, end - begin));
    for (std::size_t i = 0; i < total.size(); ++i) total[i] += sign * part[i];
    if (end < unit.size() && unit[end] == '/') sign = -1;
    begin = end + 1;
  }
  return total;
}

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
