// SPDX-License-Identifier: BSD-3-Clause
#include "element/locking.h"

#include <array>
#include <optional>
#include <tuple>
#include <type_traits>
#include <variant>

#include "element/constraints/mesh_losses.h"
#include "element/constraints/registry.h"
#include "element/joint_forces/registry.h"

namespace gelenk {

std::string_view locking_element(const JointForces& forces) {
  if (std::get<std::optional<JointFriction>>(forces)) return JointFriction::group;
  if (std::get<std::optional<JointLimit>>(forces)) return JointLimit::group;
  if (std::get<std::optional<JointOneWay>>(forces)) return JointOneWay::group;
  return {};
}

bool has_friction(const JointForces& forces) { return std::get<std::optional<JointFriction>>(forces).has_value(); }

bool is_loaded_guide(const JointForces& forces) {
  const auto& friction = std::get<std::optional<JointFriction>>(forces);
  return friction && friction->is_guide();
}

int lossy_joint(const AnyConstraint& constraint) {
  return std::visit(
      [](const auto& of) {
        if constexpr (LosesPower<std::decay_t<decltype(of)>>) {
          if (of.losses() != std::array<double, 2>{}) return of.lossy_joint;
        }
        return -1;
      },
      constraint);
}

void erase_friction(JointForces& forces) { std::get<std::optional<JointFriction>>(forces).reset(); }

void erase_locking_elements(JointForces& forces) {
  erase_friction(forces);
  std::get<std::optional<JointLimit>>(forces).reset();
  std::get<std::optional<JointOneWay>>(forces).reset();
}

}  // namespace gelenk
