// SPDX-License-Identifier: BSD-3-Clause
#include "scene_file/json_fields.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "scene_file/advice.h"
#include "util/text.h"

namespace gelenk {
namespace {

std::string in_unit(std::string_view unit) { return unit.empty() ? "" : " in " + std::string(unit); }

}  // namespace

std::string shown(const Json& value, std::string_view unit) {
  if (value.is_string()) return text::quoted(value.get_ref<const std::string&>());
  if (value.is_number_unsigned()) return text::with_unit(std::to_string(value.get<std::uint64_t>()), unit);
  if (value.is_number_integer()) return text::with_unit(std::to_string(value.get<std::int64_t>()), unit);
  if (value.is_number()) return text::with_unit(text::number(value.get<double>()), unit);
  if (value.is_boolean()) return value.get<bool>() ? "true" : "false";
  if (value.is_array()) return "a list of " + std::to_string(value.size());
  if (value.is_object()) return value.empty() ? "an empty mapping" : "a mapping";
  return "nothing";
}

std::optional<double> read_number(const Json& value, const std::string& path, Faults& faults, std::string_view unit,
                                  Range allowed) {
  if (!value.is_number()) {
    faults.add(path, shown(value), "a number" + in_unit(unit) + advice::on_number(value, unit));
    return {};
  }
  const double x = value.get<double>();
  if (!std::isfinite(x)) {
    faults.add(path, shown(value), "a finite number" + in_unit(unit));
    return {};
  }
  if (!permits(allowed, x)) {
    faults.add(path, shown(value, unit), bound(allowed, unit));
    return {};
  }
  return x;
}

std::optional<std::vector<double>> read_list(const Json& value, const std::string& path, Faults& faults,
                                             std::size_t size, std::string_view unit, Range allowed) {
  if (!value.is_array() || value.size() != size) {
    faults.add(path, shown(value),
               "a list of " + std::to_string(size) + (size == 1 ? " number" : " numbers") + in_unit(unit) +
                   advice::on_list(value, size, unit));
    return {};
  }
  std::vector<double> out;
  for (std::size_t i = 0; i < size; ++i) {
    const auto x = read_number(value[i], path + "[" + std::to_string(i + 1) + "]", faults, unit, allowed);
    if (x) out.push_back(*x);
  }
  if (out.size() != size) return {};
  return out;
}

std::optional<Eigen::Vector3d> read_vector(const Json& value, const std::string& path, Faults& faults,
                                           std::string_view unit) {
  const auto x = read_list(value, path, faults, 3, unit);
  if (!x) return {};
  return Eigen::Vector3d((*x)[0], (*x)[1], (*x)[2]);
}

std::optional<std::string> read_text(const Json& value, const std::string& path, Faults& faults,
                                     std::string_view what) {
  if (value.is_string()) return value.get<std::string>();
  faults.add(path, shown(value), std::string(what));
  return {};
}

Fields::Fields(const Json& value, std::string path, Faults& faults, const std::string& what)
    : value_(&value), path_(std::move(path)), faults_(faults), valid_(value.is_object()) {
  if (!valid_) faults_.add(path_, shown(value), what + (path_.empty() ? "" : advice::on_mapping(value)));
}

const Json* Fields::find(const std::string& key) {
  if (std::ranges::find(known_, key) == known_.end()) known_.push_back(key);
  return peek(key);
}

const Json* Fields::peek(const std::string& key) const {
  if (!valid_) return nullptr;
  const auto found = value_->find(key);
  return found == value_->end() ? nullptr : &*found;
}

const Json* Fields::require(const std::string& key, const std::string& expected) {
  const Json* value = find(key);
  if (value == nullptr && valid_) faults_.add(path(key), "nothing", expected);
  return value;
}

double Fields::number(const std::string& key, double otherwise, std::string_view unit, Range allowed) {
  const Json* value = find(key);
  if (value == nullptr) return otherwise;
  return read_number(*value, path(key), faults_, unit, allowed).value_or(otherwise);
}

double Fields::required_number(const std::string& key, std::string_view unit, Range allowed) {
  const Json* value = require(key, "a number" + in_unit(unit));
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  if (value == nullptr) return unknown;
  return read_number(*value, path(key), faults_, unit, allowed).value_or(unknown);
}

Eigen::Vector3d Fields::vector(const std::string& key, std::string_view unit) {
  const Json* value = find(key);
  if (value == nullptr) return Eigen::Vector3d::Zero();
  return read_vector(*value, path(key), faults_, unit).value_or(Eigen::Vector3d::Zero());
}

bool Fields::flag(const std::string& key, bool otherwise) {
  const Json* value = find(key);
  if (value == nullptr) return otherwise;
  if (value->is_boolean()) return value->get<bool>();
  faults_.add(path(key), shown(*value), "true or false");
  return otherwise;
}

std::string Fields::choice(const std::string& key, const std::vector<std::string>& words,
                           const std::string& otherwise) {
  const std::string expected = words.size() == 1 ? words.front() : "one of " + text::list(words);
  const Json* value = otherwise.empty() ? require(key, expected) : find(key);
  if (value == nullptr) return otherwise;
  if (value->is_string()) {
    const auto& word = value->get_ref<const std::string&>();
    if (std::ranges::find(words, word) != words.end()) return word;
    faults_.add(path(key), text::quoted(word), text::one_of(word, words, "words"));
  } else {
    faults_.add(path(key), shown(*value), expected);
  }
  return {};
}

void Fields::done() {
  if (!valid_) return;
  std::string empty;  // name of the previous field if it has no value
  for (const auto& [key, value] : value_->items()) {
    if (std::ranges::find(known_, key) == known_.end()) {
      const std::string inside = empty.empty() ? "" : "; indent it if it belongs to '" + empty + "'";
      faults_.add(path(text::printable(key)), "an unknown field",
                  text::one_of(key, known_, "fields") + advice::on_field(key, known_) + inside);
    } else {
      empty = value.is_null() ? key : "";
    }
  }
}

}  // namespace gelenk
