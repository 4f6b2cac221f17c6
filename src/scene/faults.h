// SPDX-License-Identifier: BSD-3-Clause
// Collects the errors in a scene, so that all of them are reported together, and its warnings.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace gelenk {

class Faults {
 public:
  // file: name of the scene file in messages; "scene" if empty.
  explicit Faults(std::string file);

  // Adds the error "file: path: what"; a repeated line is kept once. An empty path refers to the file as a whole.
  void add(const std::string& path, const std::string& what);
  // Adds the error "file: path: found ..., expected ...".
  void add(const std::string& path, const std::string& found, const std::string& expected);

  // Adds a warning "file: path: found ..., expected ..." about something that is valid but probably unintended.
  void warn(const std::string& path, const std::string& found, const std::string& expected);
  const std::vector<std::string>& warnings() const { return warnings_; }

  const std::string& file() const { return file_; }
  std::size_t count() const { return lines_.size(); }
  bool none() const { return lines_.empty(); }
  // Throws SceneError with all errors, if there are any.
  void raise() const;

 private:
  std::string line(const std::string& path, const std::string& what) const;

  std::string file_;
  std::vector<std::string> lines_, warnings_;
  std::set<std::string> reported_;
};

}  // namespace gelenk
