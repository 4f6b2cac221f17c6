// SPDX-License-Identifier: BSD-3-Clause
#include "element/locking.h"

#include <optional>
#include <tuple>
#include <type_traits>
#include <variant>

#include "element/constraints/registry.h"
#include "element/joint_forces/registry.h"

namespace gelenk {

namespace {

template <class E>
concept MayLock = requires(E& element) {
  element.reset();
} && (Sticks<typename E::value_type> || Blocks<typename E::value_type> || HoldsJoint<typename E::value_type>);

// Calls visit(element) for the elements, each in std::optional, that can keep the coordinate at rest.
template <class Tuple, class Visit>
void each_locking(Tuple& forces, Visit visit) {
  const auto look = [&](auto& element) {
    if constexpr (MayLock<std::remove_cvref_t<decltype(element)>>) {
      if (element) visit(element);
    }
  };
  std::apply([&](auto&... element) { (look(element), ...); }, forces);
}

}  // namespace

std::string_view locking_element(const JointForces& forces) {
  std::string_view out;
  each_locking(forces.all(), [&](const auto& element) {
    if (out.empty()) out = element->group;
  });
  return out;
}

bool takes_loads(const JointForces& forces) {
  bool any = false;
  each_locking(forces.all(), [&](const auto& element) { any = any || TakesLoads<std::decay_t<decltype(*element)>>; });
  return any;
}

bool has_bearing(const JointForces& forces) {
  bool any = false;
  each_locking(forces.all(), [&](const auto& element) {
    if constexpr (TakesLoads<std::decay_t<decltype(*element)>>) any = any || element->bearing.has_value();
  });
  return any;
}

bool is_loaded_guide(const JointForces& forces) {
  bool any = false;
  each_locking(forces.all(), [&](const auto& element) {
    if constexpr (TakesLoads<std::decay_t<decltype(*element)>>) any = any || element->is_guide();
  });
  return any;
}

int lossy_joint(const AnyConstraint& constraint) {
  return std::visit(
      [](const auto& of) {
        if constexpr (LosesPower<std::decay_t<decltype(of)>>) {
          if (of.losses().are_any()) return of.lossy_joint;
        }
        return -1;
      },
      constraint);
}

MeshLosses losses_of(const AnyConstraint& constraint) {
  return std::visit(
      [](const auto& of) -> MeshLosses {
        if constexpr (LosesPower<std::decay_t<decltype(of)>>) return of.losses();
        return {};
      },
      constraint);
}

void erase_friction(JointForces& forces) {
  each_locking(static_cast<JointForces::tuple&>(forces), [](auto& element) {
    if constexpr (Sticks<std::decay_t<decltype(*element)>>) element.reset();
  });
}

void erase_locking_elements(JointForces& forces) {
  each_locking(static_cast<JointForces::tuple&>(forces), [](auto& element) { element.reset(); });
}

}  // namespace gelenk
