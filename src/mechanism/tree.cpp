// SPDX-License-Identifier: BSD-3-Clause
// Which joints make up the tree, and which are cut.
#include <algorithm>
#include <tuple>

#include "mechanism/graph.h"

namespace gelenk {
namespace {

// Larger is kept in the tree first. A drive with inertia must be in the tree. Then: few freedoms in the tree
// means many freedoms, so few rows and no quaternions, at the cuts. Then what is driven or held.
std::tuple<bool, int, bool> preference(const Scene& scene, const Edge& edge) {
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
  return {inertia, -kind_of(edge.joint).nv, wanted};
}

}  // namespace

std::vector<int> spanning_tree(const Scene& scene, const Graph& graph) {
  std::vector<int> tree;
  std::vector<int> depth(graph.groups.size(), -1);
  depth[0] = 0;
  using Key = std::tuple<std::tuple<bool, int, bool>, int, int>;
  std::vector<std::tuple<bool, int, bool>> preferences;
  preferences.reserve(graph.edges.size());
  for (const Edge& edge : graph.edges) preferences.push_back(preference(scene, edge));
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
