// SPDX-License-Identifier: BSD-3-Clause
// The links of a mechanism as those that have inertia.
#pragma once

#include <algorithm>
#include <string>

#include "kinematics/model.h"
#include "math/bitwise.h"

namespace gelenk {

// The name of the link that moves with velocity k.
inline std::string link_moved_by(const Mechanism& mechanism, int k) {
  const auto moves = [k](const Link& link) { return k >= link.iv && k < link.iv + link.nv && link.parent >= 0; };
  const auto link = std::ranges::find_if(mechanism.links, moves);
  return link == mechanism.links.end() ? "?" : link->name;
}

// Takes the inertias of the mechanism, whose numbers may have changed since the kernels' model of it was made; returns
// whether any was another, in any bit.
template <class A>
bool take_inertias(const Mechanism& mechanism, Model<A>& model) {
  bool any = false;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    const typename A::Inertia G = inertia_in<A>(mechanism.links[i].G);
    if (is_bitwise_equal(G, model.links[i].G)) continue;
    model.links[i].G = G;
    any = true;
  }
  return any;
}

}  // namespace gelenk
