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
};

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
  for (const auto& [words, sentence] : unsupported) {
    if (contains(words, name)) return "; " + std::string(sentence);
  }
  return {};
}

std::string on_number(const Json& found, std::string_view unit) {
  if (found.is_array() && found.size() == 1) return "; leave out the brackets";
  if (!found.is_string()) return {};
  const auto& s = found.get_ref<const std::string&>();
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
  if (std::string_view("*/+-^").find(rest[0]) != std::string_view::npos) {
    return "; expressions are not evaluated: write the value";
  }
  return "; write only the number" + (unit.empty() ? "" : ", in " + std::string(unit));
}

std::string on_list(const Json& found, std::size_t size) {
  if (found.is_object()) return "; leave out the names";
  if (found.is_number() && size == 3) return "; write [x, y, z]";
  if (found.is_array() && found.size() == 1 && found[0].is_string()) return on_list(found[0], size);
  if (found.is_string()) {
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
