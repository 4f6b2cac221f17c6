// SPDX-License-Identifier: BSD-3-Clause
#include "scene/scene.h"

#include <algorithm>
#include <utility>

#include "element/locking.h"
#include "scene/faults.h"

namespace gelenk {
namespace {

std::string joined(const std::vector<std::string>& lines) {
  std::string out;
  for (const std::string& line : lines) out += (out.empty() ? "" : "\n") + line;
  return out;
}

}  // namespace

std::string_view Joint::locking_element() const {
  for (const Stored<JointForces>& forces : along) {
    if (const std::string_view found = gelenk::locking_element(*forces); !found.empty()) return found;
  }
  return {};
}

bool Joint::is_idle() const {
  return std::ranges::all_of(along, [](const Stored<JointForces>& forces) { return gelenk::is_idle(*forces); });
}

SceneError::SceneError(std::vector<std::string> lines) : std::runtime_error(joined(lines)), lines_(std::move(lines)) {}

Faults::Faults(std::string file) : file_(file.empty() ? "scene" : std::move(file)) {}

std::string Faults::line(const std::string& path, const std::string& what) const {
  return file_ + ": " + (path.empty() ? "" : path + ": ") + what;
}

void Faults::add(const std::string& path, const std::string& what) {
  std::string message = line(path, what);
  if (reported_.insert(message).second) lines_.push_back(std::move(message));
}

void Faults::add(const std::string& path, const std::string& found, const std::string& expected) {
  add(path, "found " + found + ", expected " + expected);
}

void Faults::warn(const std::string& path, const std::string& found, const std::string& expected) {
  warnings_.push_back(line(path, "found " + found + ", expected " + expected));
}

void Faults::raise() const {
  if (!none()) throw SceneError(lines_);
}

}  // namespace gelenk
