// SPDX-License-Identifier: BSD-3-Clause
// Opens loops of which no joint may be cut: a body is split into two halves, welded together by the loop-closing joint.
#include "joint/kinds.h"
#include "mechanism/graph.h"

namespace gelenk {
namespace {

// Moves the end of edge e on a group to a new group, with half of its inertia so that both have some.
void split(Graph& graph, int e, int group) {
  const int half = static_cast<int>(graph.groups.size());
  Edge& edge = graph.edges[e];
  Edge weld = edge;
  weld.joint = AnyJoint(Weld{});
  weld.opens_beside = true;
  weld.X_AF = weld.X_BM = edge.group_b == group ? edge.X_BM : edge.X_AF;
  weld.group_a = group;
  weld.group_b = half;
  (edge.group_b == group ? edge.group_b : edge.group_a) = half;
  graph.edges.push_back(weld);

  Spatial::Inertia& G = graph.groups[group].G;
  G.m /= 2;
  G.h /= 2;
  G.I /= 2;
  graph.groups.push_back({.bodies = {}, .X_GB = {}, .G = G, .half_of = group});
}

}  // namespace

Graph with_split_bodies(const Scene& scene, const Graph& graph, bool planar) {
  Graph out = graph;
  std::vector<bool> in_tree(graph.edges.size(), false);
  for (const int e : spanning_tree(scene, graph, planar)) in_tree[e] = true;
  for (int e = 0; e < static_cast<int>(in_tree.size()); ++e) {
    if (in_tree[e] || !must_not_be_cut(scene.joints[graph.edges[e].scene_joint], planar)) continue;
    for (const int group : {out.edges[e].group_b, out.edges[e].group_a}) {
      if (group == 0 || out.groups[group].G.m == 0) continue;
      split(out, e, group);
      break;
    }
  }
  return out;
}

}  // namespace gelenk
