// SPDX-License-Identifier: BSD-3-Clause
// Which body or joint of a scene has a name, for those who ask for all of them.
#pragma once

#include <string>
#include <string_view>
#include <unordered_map>

#include "scene/scene.h"

namespace gelenk {

// The scene outlives it.
class Numbers {
 public:
  explicit Numbers(const Scene& scene) {
    for (const Body& body : scene.bodies) bodies_.emplace(body.name, static_cast<int>(bodies_.size()));
    for (const Joint& joint : scene.joints) joints_.emplace(joint.name, static_cast<int>(joints_.size()));
  }
  // -1: the ground.
  int body(const std::string& name) const { return find(bodies_, name); }
  // -1: none.
  int joint(const std::string& name) const { return find(joints_, name); }

 private:
  static int find(const std::unordered_map<std::string_view, int>& in, const std::string& name) {
    const auto found = in.find(name);
    return found == in.end() ? -1 : found->second;
  }
  std::unordered_map<std::string_view, int> bodies_, joints_;
};

}  // namespace gelenk
