// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string_view>
#include <tuple>

#include "element/registry.h"

namespace gelenk {

// The group of the element that can keep the coordinate at rest, with a force that the equations of motion determine:
// dry friction, a hard limit or a one-way clutch; empty if there is none.
inline std::string_view locking_element(const JointForces& forces) {
  if (std::get<std::optional<JointFriction>>(forces)) return JointFriction::group;
  if (std::get<std::optional<JointLimit>>(forces)) return JointLimit::group;
  if (std::get<std::optional<JointOneWay>>(forces)) return JointOneWay::group;
  return {};
}

// Removes these elements.
inline void erase_locking_elements(JointForces& forces) {
  std::get<std::optional<JointFriction>>(forces).reset();
  std::get<std::optional<JointLimit>>(forces).reset();
  std::get<std::optional<JointOneWay>>(forces).reset();
}

}  // namespace gelenk
