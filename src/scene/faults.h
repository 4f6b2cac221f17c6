// SPDX-License-Identifier: BSD-3-Clause
// Everything wrong with a scene is collected here and told at once.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace gelenk {

class Faults {
 public:
  explicit Faults(std::string file);

  // "file: path: what"; the same line twice is told once. path may be empty: the file as a whole.
  void add(const std::string& path, const std::string& what);
  // "file: path: found ..., expected ...".
  void add(const std::string& path, const std::string& found, const std::string& expected);

  // What is allowed and hardly meant; it is told and hinders nothing.
  void doubt(const std::string& path, const std::string& found, const std::string& expected);
  const std::vector<std::string>& doubts() const { return doubts_; }

  const std::string& file() const { return file_; }
  std::size_t count() const { return lines_.size(); }
  bool none() const { return lines_.empty(); }
  // Throws SceneError with all lines, if there are any.
  void raise() const;

 private:
  std::string line(const std::string& path, const std::string& what) const;

  std::string file_;
  std::vector<std::string> lines_, doubts_;
  std::set<std::string> told_;
};

}  // namespace gelenk
