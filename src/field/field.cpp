// SPDX-License-Identifier: BSD-3-Clause
#include "field/field.h"

#include <algorithm>

#include "util/text.h"

namespace gelenk {
std::string unit_of(std::string_view unit, const Coordinate& coordinate) {
  std::string out(unit);
  const bool turns = coordinate.is_angle;
  text::replace(out, "{q}", turns ? "rad" : "m");
  text::replace(out, "{v}", turns ? "rad/s" : "m/s");
  text::replace(out, "{a}", turns ? "rad/s2" : "m/s2");
  text::replace(out, "{f}", turns ? "N.m" : "N");
  text::replace(out, "{J}", turns ? "kg.m2" : "kg");
  return out;
}

std::string unit_of(const Field& field, const Coordinate& coordinate, std::size_t i) {
  std::string unit = unit_of(field.unit, coordinate);
  if (!field.by_time || i == 0) return unit;
  return unit + "/s" + (i > 1 ? std::to_string(i) : "");
}

std::string spelled(std::string unit) {
  if (unit == "1") return {};
  std::ranges::replace(unit, '.', ' ');
  return unit;
}

}  // namespace gelenk
