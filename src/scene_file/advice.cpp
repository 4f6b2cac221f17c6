// SPDX-License-Identifier: BSD-3-Clause
#include "scene_file/advice.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "util/synonyms.h"
#include "util/text.h"

namespace gelenk::advice {
namespace {

// Words of other formats that scenes do not have, and what to use instead.
constexpr std::pair<Words, std::string_view> unsupported[] = {
    {"frictionloss coulomb", "dry friction is `friction: {coulomb: ...}`"},
    {"effort velocity max_force max_torque", "limits of torque, force and velocity are not modeled"},
    {"visual collision geometry geom mesh shape color",
     "shapes are in a mapping, shapes: {NAME: {box: [..]}}, and have no color"},
    {"density", "give `mass` and `inertia`"},
    {"motor actuated driven", "motors are in a separate section, motors: {NAME: {joint: JOINT}}"},
    {"units unit", "numbers are in SI units, angles in rad: leave it out"},
    {"method algorithm scheme", "the numerical method is `solver: {integrator: auto}`"},
    {"rtol atol tol reltol abstol", "the tolerance is `experiment: {tolerance: 1e-6}`"},
    {"viscous viscosity", "viscous friction is `damping` of the joint"},
    {"mu mu_s mu_k", "`coulomb` is a torque or force; a coefficient of friction is `bearing: {coefficient: ...}`"},
    {"lower upper", "limits are in a mapping, limit: {lower: ..., upper: ...}"},
    {"ixx iyy izz ixy ixz iyz", "write inertia: [xx, yy, zz] or [xx, yy, zz, xy, xz, yz]"},
    {"rpy_deg euler_deg rpy_degrees degrees deg", "angles are in rad: 90 degrees are 1.5708 rad"},
    {"include import imports includes", "a scene is one file"},
};

// What people give a motor to act with.
constexpr Words motor_values =
    "tau torque f force effort value amplitude signal voltage current kp ki kd gain gains controller control law table";
constexpr std::string_view motor_inputs =
    "; what a motor exerts is an input of each run, such as NAME.tau or NAME.f: --set NAME.tau=3, --input FILE.csv";
constexpr std::string_view constant_numbers =
    "; numbers of a scene are constant: what depends on time is an input, of a motor or of a wrench with `input: true`";

// Units that are often written behind a number: their value in units of scene files.
struct OtherUnit {
  std::string_view name, unit;
  double value;
};
constexpr OtherUnit other_units[] = {
    {"g", "kg", 1e-3},         {"t", "kg", 1e3},         {"mm", "m", 1e-3},        {"cm", "m", 1e-2},
    {"km", "m", 1e3},          {"um", "m", 1e-6},        {"ms", "s", 1e-3},        {"min", "s", 60},
    {"kN", "N", 1e3},          {"mN", "N", 1e-3},        {"Nmm", "N m", 1e-3},     {"N mm", "N m", 1e-3},
    {"kNm", "N m", 1e3},       {"N/mm", "N/m", 1e3},     {"kN/m", "N/m", 1e3},     {"kg mm2", "kg m2", 1e-6},
    {"kg cm2", "kg m2", 1e-4}, {"g mm2", "kg m2", 1e-9}, {"kg/dm3", "kg/m3", 1e3}, {"g/cm3", "kg/m3", 1e3}};

bool all_digits(std::string_view s) {
  return !s.empty() && std::ranges::all_of(s, [](char c) { return c >= '0' && c <= '9'; });
}

// Recognizes "key:value"; a time or an address has no identifier before its colon.
bool lacks_space(std::string_view s) {
  const std::size_t colon = s.find(':');
  return colon != s.npos && colon + 1 < s.size() && s[colon + 1] != ' ' && text::is_identifier(s.substr(0, colon));
}

std::string missing_space(std::string_view s) {
  const std::size_t colon = s.find(':') + 1;
  return "; write " + text::quoted(std::string(s.substr(0, colon)) + " " + std::string(s.substr(colon))) +
         ", with a space after the colon";
}

// Returns the number of consecutive digits from `at`.
std::size_t digits(std::string_view s, std::size_t at) {
  std::size_t n = 0;
  while (at + n < s.size() && s[at + n] >= '0' && s[at + n] <= '9') ++n;
  return n;
}

std::size_t sign(std::string_view s, std::size_t at) { return at < s.size() && (s[at] == '-' || s[at] == '+') ? 1 : 0; }

struct Beginning {
  std::string_view number, rest;  // without the spaces between them
};

// Splits a text that begins with a number. from_chars is not used: the FMU would require a newer C library.
std::optional<Beginning> number_and_rest(std::string_view s) {
  std::size_t at = sign(s, 0);
  const std::size_t whole = digits(s, at);
  at += whole;
  std::size_t fraction = 0;
  if (at < s.size() && s[at] == '.') {
    fraction = digits(s, at + 1);
    at += 1 + fraction;
  }
  if (whole + fraction == 0) return {};
  if (at < s.size() && (s[at] == 'e' || s[at] == 'E')) {
    const std::size_t power = at + 1 + sign(s, at + 1);
    if (digits(s, power) > 0) at = power + digits(s, power);
  }
  std::string_view rest = s.substr(at);
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  return Beginning{s.substr(0, at), rest};
}

// Returns the value of a number without exponent, accurate to the six digits that are shown.
std::optional<double> value_of(std::string_view number) {
  const std::size_t from = sign(number, 0);
  double value = 0;
  double unit = 0;  // value of 1 in the last decimal place; 0 before the point
  for (const char c : number.substr(from)) {
    if (c == '.') {
      unit = 1;
    } else if (c >= '0' && c <= '9') {
      unit /= 10;
      value = unit > 0 ? value + unit * (c - '0') : 10 * value + (c - '0');
    } else {
      return {};
    }
  }
  return number.starts_with('-') ? -value : value;
}

// Converts `size` numbers separated by spaces, as in XML files, to "[0, 0, 1]"; empty for any other text.
std::string spaced_list(std::string_view s, std::size_t size) {
  std::vector<std::string> numbers;
  while (!s.empty()) {
    const auto found = number_and_rest(s);
    if (!found) return {};
    numbers.emplace_back(found->number);
    s = found->rest;
  }
  return numbers.size() == size ? "[" + text::list(numbers) + "]" : "";
}

// Recognizes a mapping or a formula for a value that depends on time.
bool depends_on_time(const Json& value) {
  if (value.is_object()) {
    return std::ranges::any_of(value.items(), [](const auto& item) {
      return contains("table file csv function expression formula time times points t", item.key());
    });
  }
  if (!value.is_string()) return false;
  const auto& s = value.get_ref<const std::string&>();
  return s.find("(t)") != s.npos || s.find("sin(") != s.npos || s.find("cos(") != s.npos || s.find("*t") != s.npos;
}

// Returns the direction that one letter with a sign means: "[0, 1, 0]" for y; empty for any other text.
std::string axis_of_letter(std::string_view s) {
  const bool negative = s.starts_with('-');
  if (negative || s.starts_with('+')) s.remove_prefix(1);
  const std::size_t axis = s.size() == 1 ? std::string_view("xyzXYZ").find(s[0]) : std::string_view::npos;
  if (axis == std::string_view::npos) return {};
  std::vector<std::string> numbers(3, "0");
  numbers[axis % 3] = negative ? "-1" : "1";
  return "[" + text::list(numbers) + "]";
}

// Returns the value with another unit in that of the scene file: "; 500 g are 0.5 kg"; empty for unknown units.
std::string converted(const Beginning& of, std::string_view unit) {
  const auto x = value_of(of.number);
  if (!x) return {};
  if (of.rest == "%") return "; write the fraction: " + text::rounded(*x / 100);
  for (const OtherUnit& other : other_units) {
    if (other.unit != unit || other.name != of.rest) continue;
    return "; " + text::rounded(*x) + " " + std::string(other.name) + " are " + text::rounded(*x * other.value) + " " +
           std::string(unit);
  }
  return {};
}

bool is_matrix(const Json& value) {
  if (!value.is_array() || value.size() != 3) return false;
  return std::ranges::all_of(value, [](const Json& row) {
    return row.is_array() && row.size() == 3 && std::ranges::all_of(row, [](const Json& x) { return x.is_number(); });
  });
}

}  // namespace

std::string on_field(std::string_view name, const std::vector<std::string>& known) {
  if (all_digits(name)) return "; use a decimal point: a comma separates entries";
  if (lacks_space(name)) return missing_space(name);
  if (!canonical_name(name, known).empty() || !text::nearest(name, known).empty()) return {};
  const bool motor = std::ranges::find(known, "rotor_inertia") != known.end();
  if (motor && contains(motor_values, name)) return std::string(motor_inputs);
  for (const auto& [words, sentence] : unsupported) {
    if (contains(words, name)) return "; " + std::string(sentence);
  }
  return {};
}

std::string on_number(const Json& found, std::string_view unit) {
  if (found.is_array() && found.size() == 1) return "; leave out the brackets";
  if (depends_on_time(found)) return std::string(constant_numbers);
  if (!found.is_string()) return {};
  const auto& s = found.get_ref<const std::string&>();
  if (s.starts_with("\u2212")) return "; write the sign as '-'";  // the minus sign of texts
  const auto number = number_and_rest(s);
  if (!number) {
    return s.find("pi") != s.npos ? "; expressions are not evaluated: write the value, pi is 3.141592653589793" : "";
  }
  const std::string_view rest = number->rest;
  if (rest.empty()) return "; leave out the quotes";
  if (rest[0] == ',' && all_digits(rest.substr(1))) {
    return "; use a decimal point: " + s.substr(0, s.find(',')) + "." + std::string(rest.substr(1));
  }
  if (unit == "rad" && (rest.starts_with("deg") || rest == "°")) {
    const auto x = value_of(number->number);
    if (x) return "; " + text::rounded(*x) + " degrees are " + text::rounded(*x * std::numbers::pi / 180) + " rad";
  }
  if (std::string other = converted(*number, unit); !other.empty()) return other;
  if (rest[0] == '_') return "; write it without '_'";
  if (std::string_view("*/+-^").find(rest[0]) != std::string_view::npos) {
    return "; expressions are not evaluated: write the value";
  }
  return "; write only the number" + (unit.empty() ? "" : ", in " + std::string(unit));
}

std::string on_list(const Json& found, std::size_t size, std::string_view unit) {
  if (depends_on_time(found)) return std::string(constant_numbers);
  if (found.is_object()) return "; leave out the names";
  if (found.is_number() && size == 3) return "; write [x, y, z]";
  if (found.is_array() && found.size() == 1 && found[0].is_string()) return on_list(found[0], size, unit);
  if (found.is_string()) {
    const std::string axis = size == 3 && unit.empty() ? axis_of_letter(found.get_ref<const std::string&>()) : "";
    if (!axis.empty()) return "; write " + axis;
    const std::string list = spaced_list(found.get_ref<const std::string&>(), size);
    return list.empty() ? "" : "; write " + list;
  }
  const auto whole = [](const Json& x) { return x.is_number_integer() && x.get<double>() >= 0; };
  if (found.is_array() && found.size() > size && std::ranges::all_of(found, whole)) {
    return "; use a decimal point: a comma separates numbers";
  }
  return {};
}

std::string on_mapping(const Json& found) {
  if (found.is_null()) return "; lines that belong to it must be indented further than its name";
  if (found.is_string() && lacks_space(found.get_ref<const std::string&>())) {
    return missing_space(found.get_ref<const std::string&>());
  }
  return {};
}

std::string on_section(const Json& found) {
  if (found.is_array()) return "; write `NAME: {...}` for each in place of `- {...}`";
  if (found.is_null()) return "; its entries must be indented further than its name";
  return on_mapping(found);
}

std::string on_inertia(const Json& found) {
  if (found.is_object()) return "; leave out the names";
  if (!is_matrix(found)) return {};
  std::vector<std::string> numbers;
  constexpr std::pair<std::size_t, std::size_t> places[] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
  for (const auto& [i, j] : places) {
    if (found[i][j].get<double>() != found[j][i].get<double>()) return "; this matrix is not symmetric";
    numbers.push_back(text::number(found[i][j].get<double>()));
  }
  return "; for this matrix, write [" + text::list(numbers) + "]";
}

}  // namespace gelenk::advice
