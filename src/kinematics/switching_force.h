// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string_view>
#include <vector>

namespace gelenk {

struct Loads;

// A force with modes.
struct SwitchingForce {
  int joint, component;    // joint of the scene, and which of its coordinates
  std::string_view group;  // key of the element in the joint
  // For each of its two event indicators the events at which it becomes negative and positive, with placeholders
  // (element/element.h).
  std::array<std::array<std::string_view, 2>, 2> events;
  bool holds_joint = false;  // a lock of the whole joint
};

// All forces with modes, in the order of SwitchingForces.
std::vector<SwitchingForce> switching_forces_of(const Loads& loads);

}  // namespace gelenk
