// SPDX-License-Identifier: BSD-3-Clause
// Reading single values and mappings of a scene file. A value that is not as expected becomes an error with its path;
// reading continues with a substitute, so that all errors are found.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "field/field.h"
#include "scene/faults.h"
#include "scene_file/json_tree.h"

namespace gelenk {

// Returns a short description of a value for "found ...": "'abc'", "-1 kg", "a list of 2".
std::string shown(const Json& value, std::string_view unit = {});

// Each of these adds an error and returns nothing if the value has another type or size, is not finite or is outside
// the permitted range.
std::optional<double> read_number(const Json& value, const std::string& path, Faults& faults, std::string_view unit,
                                  Range allowed = Range::any);
std::optional<std::vector<double>> read_list(const Json& value, const std::string& path, Faults& faults,
                                             std::size_t size, std::string_view unit, Range allowed = Range::any);
std::optional<Eigen::Vector3d> read_vector(const Json& value, const std::string& path, Faults& faults,
                                           std::string_view unit);
std::optional<std::string> read_text(const Json& value, const std::string& path, Faults& faults, std::string_view what);

template <class Numbers>
Json numbers_of(const Numbers& numbers) {
  Json out = Json::array();
  for (const double x : numbers) out.push_back(x);
  return out;
}

// A mapping. All known fields must have been looked up before done(), which reports the others as unknown.
class Fields {
 public:
  // what: description of the mapping for the error if the value is not one; then no field is found.
  Fields(const Json& value, std::string path, Faults& faults, const std::string& what);

  bool valid() const { return valid_; }
  std::string path(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }
  const std::string& path() const { return path_; }
  Faults& faults() { return faults_; }

  // Returns the value of a field, or nullptr if it is missing; the key is known from now on.
  const Json* find(const std::string& key);
  // The same, but the key remains unknown.
  const Json* peek(const std::string& key) const;
  // As find(), but adds the error "found nothing, expected ..." if the field is missing.
  const Json* require(const std::string& key, const std::string& expected);

  // These return the value of a field, or `otherwise` if it is missing or wrong.
  double number(const std::string& key, double otherwise, std::string_view unit, Range allowed = Range::any);
  // Returns NaN after an error.
  double required_number(const std::string& key, std::string_view unit, Range allowed = Range::any);
  Eigen::Vector3d vector(const std::string& key, std::string_view unit);  // zero if missing
  bool flag(const std::string& key, bool otherwise);
  // Returns one of the words; `otherwise` if the field is missing (an error if that is empty); empty after an error.
  std::string choice(const std::string& key, const std::vector<std::string>& words, const std::string& otherwise);

  // Adds an error for each field that has not been looked up.
  void done();

 private:
  const Json* value_;
  std::string path_;
  Faults& faults_;
  bool valid_;
  std::vector<std::string> known_;
};

}  // namespace gelenk
