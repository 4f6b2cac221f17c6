// SPDX-License-Identifier: BSD-3-Clause
// Which joints make up the tree, and which are cut.
#include <algorithm>
#include <tuple>

#include "mechanism/graph.h"

namespace gelenk {
namespace {

// Drive with inertia, massless part, fewness of freedoms, driven or held.
using Preference = std::tuple<bool, bool, int, bool>;

// Larger is kept in the tree first. A drive with inertia must be in the tree. A part without mass must carry one with
// mass there, or M is singular: a cut beside it would leave it at the end of a branch. Few freedoms in the tree mean
// many freedoms, so few rows and no quaternions, at the cuts.
Preference preference(const Scene& scene, const Graph& graph, const Edge& edge) {
  const Joint& joint = scene.joints[edge.scene_joint];
  bool driven = false;
  bool inertia = false;
  for (const Motor& motor : scene.motors) {
    if (motor.joint != joint.name) continue;
    driven = true;
    inertia = inertia || motor.rotor_inertia > 0;
  }
  const auto any = [](const auto& values) { return std::ranges::any_of(values, [](auto x) { return x != 0; }); };
  const bool wanted = driven || any(joint.start.q_fixed) || any(joint.stiffness) || any(joint.damping);
  const auto massless = [&](int group) { return group != 0 && graph.groups[group].G.m == 0; };
  return {inertia, massless(edge.group_a) || massless(edge.group_b), -kind_of(edge.joint).nv, wanted};
}

}  // namespace

std::vector<int> spanning_tree(const Scene& scene, const Graph& graph) {
  std::vector<int> tree;
  std::vector<int> depth(graph.groups.size(), -1);
  depth[0] = 0;
  using Key = std::tuple<Preference, int, int>;
  std::vector<Preference> preferences;
  preferences.reserve(graph.edges.size());
  for (const Edge& edge : graph.edges) preferences.push_back(preference(scene, graph, edge));
  // Prim's algorithm; among equals the shallower, then the earlier in the file: short chains make short columns.
  while (tree.size() + 1 < graph.groups.size()) {
    int best = -1;
    Key best_key;
    for (int e = 0; e < static_cast<int>(graph.edges.size()); ++e) {
      const Edge& edge = graph.edges[e];
      if ((depth[edge.group_a] < 0) == (depth[edge.group_b] < 0)) continue;
      const Key key{preferences[e], -std::max(depth[edge.group_a], depth[edge.group_b]), -e};
      if (best >= 0 && key <= best_key) continue;
      best = e;
      best_key = key;
    }
    if (best < 0) break;  // not connected: the scene's checks have told
    const Edge& edge = graph.edges[best];
    const int reached = std::max(depth[edge.group_a], depth[edge.group_b]) + 1;
    depth[depth[edge.group_a] < 0 ? edge.group_a : edge.group_b] = reached;
    tree.push_back(best);
  }
  return tree;
}

}  // namespace gelenk
