// SPDX-License-Identifier: BSD-3-Clause
// Reading one value, or one mapping of values, of a scene file. Whatever is not as expected becomes a fault
// with its path; reading then goes on with a stand-in, so that all faults are found.
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

// A short description of a value for "found ...": "'abc'", "-1 kg", "a list of 2".
std::string shown(const Json& value, std::string_view unit = {});

// Each adds a fault and returns nothing when the value is of another kind or size, not finite or not allowed.
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

// A mapping. Fields must be asked for before done(), which turns the rest into faults.
class Fields {
 public:
  // what: "a joint", for the message when the value is not a mapping; then has() is false for all fields.
  Fields(const Json& value, std::string path, Faults& faults, const std::string& what);

  bool valid() const { return valid_; }
  std::string path(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }
  const std::string& path() const { return path_; }
  Faults& faults() { return faults_; }

  // The value, or nullptr. Asking makes the key a known one.
  const Json* find(const std::string& key);
  // Likewise, and a fault "found nothing, expected ..." when it is missing.
  const Json* require(const std::string& key, const std::string& expected);

  double number(const std::string& key, double otherwise, std::string_view unit, Range allowed = Range::any);
  // NaN after a fault.
  double required_number(const std::string& key, std::string_view unit, Range allowed = Range::any);
  Eigen::Vector3d vector(const std::string& key, std::string_view unit);  // zero when missing
  bool flag(const std::string& key, bool otherwise);
  // One of the words; `otherwise` when missing (a fault if that is empty); empty after a fault.
  std::string choice(const std::string& key, const std::vector<std::string>& words, const std::string& otherwise);

  void done();

 private:
  const Json* value_;
  std::string path_;
  Faults& faults_;
  bool valid_;
  std::vector<std::string> known_;
};

}  // namespace gelenk
