// SPDX-License-Identifier: BSD-3-Clause
#include "kinematics/loads.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

#include "kinematics/switching_force.h"

namespace gelenk {

bool JointLoads::stores_nothing() const {
  bool out = true;
  each_list(lists, [&](const auto& list) {
    using E = std::decay_t<decltype(list.front().element)>;
    if constexpr (requires(const E& element) { element.energy(0.0); }) out = out && list.empty();
  });
  return out;
}

std::vector<int> all_links(const Mechanism& mechanism) {
  std::vector<int> out(mechanism.links.size() - 1);
  std::iota(out.begin(), out.end(), 1);
  return out;
}

std::vector<int> links_with_loads(const Mechanism& mechanism, const Loads& loads) {
  std::vector<bool> needed(mechanism.links.size(), false);
  mark_links(*loads.forces, needed);
  for (const LinkShape& shape : mechanism.shapes) needed[shape.link] = true;
  for (const Swing& swing : mechanism.swings) needed[swing.link_a] = needed[swing.link_b] = true;
  for (const LinkFriction& of : mechanism.frictions) needed[of.link_a] = needed[of.link_b] = true;
  for (const NamedQuantity& named : loads.named) {
    if (named.reading != nullptr) named.reading->mark_links(needed);
  }
  for (std::size_t i = mechanism.links.size() - 1; i > 0; --i) {
    if (needed[i]) needed[mechanism.links[i].parent] = true;
  }
  std::vector<int> out;
  for (int i = 1; i < static_cast<int>(needed.size()); ++i) {
    if (needed[i]) out.push_back(i);
  }
  return out;
}

std::vector<SwitchingForce> switching_forces_of(const Loads& loads) {
  std::vector<SwitchingForce> out;
  const auto add = [&](const auto& force) {
    SwitchingForce& of = out.emplace_back(SwitchingForce{force.joint, force.component, force.element.group, {}});
    of.holds_joint = HoldsJoint<std::decay_t<decltype(force.element)>>;
    if constexpr (requires { force.element.is_excess(); }) {
      if (force.element.is_excess()) return;
    }
    const auto& events = force.element.events;
    of.events = {{{events[0][0], events[0][1]}, {events[1][0], events[1][1]}}};
  };
  loads.tree.each_switching(add);
  for (const JointLoads& on : loads.cuts) on.each_switching(add);
  return out;
}

}  // namespace gelenk
