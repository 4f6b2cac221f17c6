// SPDX-License-Identifier: BSD-3-Clause
// The choice of the spanning tree: which joints are tree joints, and which are cut.
#include <algorithm>
#include <queue>
#include <string_view>
#include <tuple>
#include <unordered_set>

#include "mechanism/graph.h"
#include "scene/component_parts.h"
#include "scene/formulas.h"

namespace gelenk {
namespace {

// Must be in the tree (2), or else a body must be split beside it (1); connects a massless part; few velocities; no
// quaternion; driven or held.
using Preference = std::tuple<int, bool, int, bool, bool>;

// Edges with larger preference enter the tree first. Two criteria are necessary: joints with motor inertia, joints
// whose coordinate is constrained and, with an exception in the plane, joints with friction must be in the tree, and a
// massless part must carry a part with mass there, since a cut next to it would leave it at the end of a branch, and M
// would be singular. The other criteria are the choice of cuts: few velocities in the tree mean few constraint
// equations at the cuts, since the joints there permit more motions. The greedy choice of edges is optimal (Kruskal
// 1956).
class Preferences {
 public:
  Preferences(const Scene& scene, const Graph& graph, bool planar) : scene_(scene), graph_(graph), planar_(planar) {
    for (const DrivenJoint& driven : driven_joints(scene)) {
      driven_or_held_.insert(driven.joint);
      if (driven.inertia > 0) must_be_in_tree_.insert(driven.joint);
    }
    for (const std::string_view joint : constrained_joints(scene)) must_be_in_tree_.insert(joint);
    named_ = named_of_motion(scene);
  }

  Preference operator()(const Edge& edge) const {
    if (edge.opens_beside) return {0, false, -7, false, false};  // last of all
    const Joint& joint = scene_.joints[edge.scene_joint];
    const int required = must_be_in_tree_.contains(joint.name) ? 2 : must_not_be_cut(joint, planar_) ? 1 : 0;
    const bool massless = without_mass(edge.group_a) || without_mass(edge.group_b);
    if (!scene_.solver.reduces(Reduction::cut_choice)) return {required, massless, 0, false, false};
    const JointKind& kind = kind_of(*edge.joint);
    const auto any = [](const auto& values) { return std::ranges::any_of(values, [](auto x) { return x != 0; }); };
    const bool driven_or_held = driven_or_held_.contains(joint.name) || any(joint.start.q_fixed) || !joint.is_idle() ||
                                named_.contains(joint.name);
    return {required, massless, -kind.nv, !kind.has_quaternion(), driven_or_held};
  }

 private:
  bool without_mass(int group) const { return group != 0 && graph_.groups[group].G.m == 0; }

  const Scene& scene_;
  const Graph& graph_;
  bool planar_;
  std::unordered_set<std::string_view> driven_or_held_, must_be_in_tree_;
  std::unordered_set<std::string> named_;  // by expressions
};

}  // namespace

bool must_not_be_cut(const Joint& joint, bool planar) {
  if (joint.locking_element().empty()) return false;
  const bool turns_in_plane = planar && kind_of(*joint.is).planar == PlanarRole::normal && kind_of(*joint.is).nv == 1;
  return !turns_in_plane;
}

std::vector<int> spanning_tree(const Scene& scene, const Graph& graph, bool planar) {
  const Preferences preference(scene, graph, planar);
  const auto edges_of = graph.edges_of_groups();
  std::vector<int> tree;
  std::vector<int> depth(graph.groups.size(), -1);
  // Prim's algorithm. Ties are broken by depth, since short chains have short columns and little rounding, then by the
  // order of the file.
  using Key = std::tuple<Preference, int, int>;
  std::priority_queue<Key> open;
  const auto reach = [&](int group, int at_depth) {
    depth[group] = at_depth;
    for (const int e : edges_of[group]) {
      const Edge& edge = graph.edges[e];
      const int other = edge.group_a == group ? edge.group_b : edge.group_a;
      if (depth[other] < 0) open.emplace(preference(edge), -at_depth, -e);
    }
  };
  reach(0, 0);
  while (!open.empty()) {
    const auto [preferred, above, negative] = open.top();
    open.pop();
    const Edge& edge = graph.edges[-negative];
    const bool from_a = depth[edge.group_a] >= 0;
    const int other = from_a ? edge.group_b : edge.group_a;
    if (depth[other] >= 0) continue;
    tree.push_back(-negative);
    reach(other, 1 - above);
  }
  return tree;
}

}  // namespace gelenk
