// SPDX-License-Identifier: BSD-3-Clause
// Finds the bodies and joints of a scene by name, with hash tables built once.
#pragma once

#include <string>
#include <string_view>
#include <unordered_map>

#include "scene/scene.h"

namespace gelenk {

// Refers to the names in the scene, which must outlive it.
class NameIndex {
 public:
  explicit NameIndex(const Scene& scene) {
    for (const Body& body : scene.bodies) bodies_.emplace(body.name, static_cast<int>(bodies_.size()));
    for (const Joint& joint : scene.joints) joints_.emplace(joint.name, static_cast<int>(joints_.size()));
  }
  // Returns the index of the body with this name among scene.bodies; -1 for the ground and for unknown names.
  int body(const std::string& name) const { return find(bodies_, name); }
  // Returns the index of the joint with this name among scene.joints; -1 for unknown names.
  int joint(const std::string& name) const { return find(joints_, name); }

 private:
  static int find(const std::unordered_map<std::string_view, int>& in, const std::string& name) {
    const auto found = in.find(name);
    return found == in.end() ? -1 : found->second;
  }
  std::unordered_map<std::string_view, int> bodies_, joints_;
};

}  // namespace gelenk
