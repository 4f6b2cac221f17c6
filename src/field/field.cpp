// SPDX-License-Identifier: BSD-3-Clause
#include "field/field.h"

#include <algorithm>

#include "util/text.h"

namespace gelenk {

std::string unit_of(std::string_view unit, const Coordinate& coordinate) {
  std::string out(unit);
  const bool is_angle = coordinate.is_angle;
  text::replace(out, "{q}", is_angle ? "rad" : "m");
  text::replace(out, "{v}", is_angle ? "rad/s" : "m/s");
  text::replace(out, "{a}", is_angle ? "rad/s2" : "m/s2");
  text::replace(out, "{f}", is_angle ? "N.m" : "N");
  text::replace(out, "{J}", is_angle ? "kg.m2" : "kg");
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

bool permits(Range allowed, double x) {
  switch (allowed) {
    case Range::not_negative:
      return x >= 0;
    case Range::positive:
      return x > 0;
    case Range::not_zero:
      return x != 0;
    case Range::fraction:
      return x >= 0 && x <= 1;
    case Range::at_most_one:
      return x <= 1;
    case Range::any:
      break;
  }
  return true;
}

std::string bound(Range allowed, std::string_view unit) {
  switch (allowed) {
    case Range::not_negative:
      return text::with_unit("0", unit) + " or more";
    case Range::positive:
      return "more than " + text::with_unit("0", unit);
    case Range::not_zero:
      return "a number other than 0";
    case Range::fraction:
      return "0 to 1";
    case Range::at_most_one:
      return "1 or less";
    case Range::any:
      break;
  }
  return unit.empty() ? "a number" : "a number in " + std::string(unit);
}

std::span<Formula> formulas_of(const Field& field, void* element) {
  if (field.type == Field::Type::formula) return {&field.of<Formula>(element), 1};
  if (field.type == Field::Type::formulas) return field.of<std::array<Formula, 3>>(element);
  return {};
}

std::span<const Formula> formulas_of(const Field& field, const void* element) {
  return formulas_of(field, const_cast<void*>(element));  // NOLINT(*-const-cast): only read
}

namespace {

// Whether the variable is the coordinate itself or its speed: "phi" is that of a revolute joint, and becomes "phi_a" of
// a universal one.
bool is_own(const FormulaVariable& variable, const Coordinate& coordinate) {
  const std::string_view q = coordinate.is_angle ? "rad" : "m";
  return variable.unit == q || (variable.unit.starts_with(q) && variable.unit.ends_with("/s"));
}

}  // namespace

std::vector<FormulaVariable> variables_of(const Field& field, const Coordinate& coordinate) {
  std::vector<FormulaVariable> out(field.variables.begin(), field.variables.end());
  for (FormulaVariable& variable : out) {
    if (coordinate.name.empty() || variable.everywhere || variable.unit == "s") continue;
    const bool is_speed = variable.unit.ends_with("/s");
    variable.name = !is_own(variable, coordinate) ? std::string_view() : is_speed ? coordinate.speed : coordinate.name;
  }
  return out;
}

bool is_given(const Field& field, const void* element) {
  switch (field.type) {
    case Field::Type::number:
      return std::isfinite(field.of<double>(element));
    case Field::Type::numbers:
      return !field.of<std::vector<double>>(element).empty();
    case Field::Type::choice:
      return field.of<Choice>(element).index != Choice::none;
    case Field::Type::formula:
    case Field::Type::formulas:
      return formulas_of(field, element).front().is_given();
    case Field::Type::group:
      return field.in(element) != nullptr;
    default:
      return true;
  }
}

std::vector<std::vector<std::string>> alternatives_of(std::span<const Field> fields) {
  std::vector<std::vector<std::string>> out;
  for (const Field& field : fields) {
    if (field.alternative == 0) continue;
    out.resize(std::max(out.size(), static_cast<std::size_t>(field.alternative)));
    out[static_cast<std::size_t>(field.alternative) - 1].emplace_back(field.name);
  }
  return out;
}

}  // namespace gelenk
