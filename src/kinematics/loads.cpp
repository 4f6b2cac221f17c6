// SPDX-License-Identifier: BSD-3-Clause
#include "kinematics/loads.h"

#include <algorithm>
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

std::vector<int> links_with_loads(const Mechanism& mechanism, const Loads& loads) {
  std::vector<bool> needed(mechanism.links.size(), false);
  mark_links(*loads.forces, needed);
  for (const LinkShape& shape : mechanism.shapes) needed[shape.link] = true;
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

std::vector<BranchPlace> branch_places(const Loads& loads) {
  std::vector<BranchPlace> out;
  const auto add = [&](const Formula& formula, const BranchPlace& place) {
    const auto first = static_cast<std::size_t>(formula.first_branch());
    const auto count = static_cast<std::size_t>(formula.branches());
    out.resize(std::max(out.size(), first + count));
    std::ranges::fill(std::span(out).subspan(first, count), place);
  };
  const auto of_joint = [&](const auto& force) { add(force.element.formula(), {BranchPlace::Of::joint, force.joint}); };
  loads.tree.each_formula(of_joint);
  for (const JointLoads& on : loads.cuts) on.each_formula(of_joint);
  each_formula(std::as_const(*loads.forces), [&](const Formula& formula, int force) {
    add(formula, {force < 0 ? BranchPlace::Of::gravity : BranchPlace::Of::force, force});
  });
  for (int k = 0; k < loads.states(); ++k) add(loads.rates[static_cast<std::size_t>(k)], {BranchPlace::Of::state, k});
  return out;
}

}  // namespace gelenk
