// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <variant>

#include "element/mesh_losses.h"
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

inline bool has_friction(const JointForces& forces) {
  return std::get<std::optional<JointFriction>>(forces).has_value();
}
// Whether the friction depends on the force that the joint transmits; and whether it is one across a guide.
inline bool has_bearing(const JointForces& forces) {
  const auto& friction = std::get<std::optional<JointFriction>>(forces);
  return friction && friction->bearing;
}
inline bool is_loaded_guide(const JointForces& forces) {
  const auto& friction = std::get<std::optional<JointFriction>>(forces);
  return friction && friction->is_guide();
}
// Whether the position and the speed are bounded, which excludes each other.
inline bool has_two_bounds(const JointForces& forces) {
  return std::get<std::optional<JointLimit>>(forces) && std::get<std::optional<JointOneWay>>(forces);
}
// Which of its joints has the friction by which a constraint loses power; -1: it loses none.
inline int lossy_joint(const AnyConstraint& constraint) {
  return std::visit(
      [](const auto& of) {
        if constexpr (LosesPower<std::decay_t<decltype(of)>>) {
          if (of.losses() != std::array<double, 2>{}) return of.lossy_joint;
        }
        return -1;
      },
      constraint);
}

// Removes these elements.
inline void erase_locking_elements(JointForces& forces) {
  std::get<std::optional<JointFriction>>(forces).reset();
  std::get<std::optional<JointLimit>>(forces).reset();
  std::get<std::optional<JointOneWay>>(forces).reset();
}

}  // namespace gelenk
