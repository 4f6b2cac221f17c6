// SPDX-License-Identifier: BSD-3-Clause
// Parts of a scene that nothing couples can be solved apart, each with its own steps.
#include "mechanism/graph.h"
#include "mechanism/sets.h"

namespace gelenk {
namespace {

Sets coupled(const Scene& scene, const Graph& graph) {
  Sets sets(graph.groups.size());
  const auto couple = [&](int a, int b) {
    if (a != 0 && b != 0) sets.join(a, b);  // the ground couples nothing
  };
  for (const Edge& edge : graph.edges) couple(edge.group_a, edge.group_b);
  const BodyNumbers number(scene);
  std::vector<int> group_of(scene.bodies.size() + 1, 0);
  for (int g = 0; g < static_cast<int>(graph.groups.size()); ++g) {
    for (const int body : graph.groups[g].bodies) group_of[body + 1] = g;
  }
  for (const Force& force : scene.forces) {
    if (force.type != ForceType::spring_damper) continue;
    couple(group_of[number(force.from.body) + 1], group_of[number(force.to.body) + 1]);
  }
  return sets;
}

}  // namespace

std::vector<Graph> islands_of(const Scene& scene, const Graph& graph) {
  Sets sets = coupled(scene, graph);
  std::vector<Graph> out;
  std::vector<int> part_of_set(graph.groups.size(), -1);
  std::vector<int> part(graph.groups.size(), -1);   // by group
  std::vector<int> number(graph.groups.size(), 0);  // by group: its number in its part
  for (int g = 1; g < static_cast<int>(graph.groups.size()); ++g) {
    int& p = part_of_set[sets.find(g)];
    if (p < 0) {
      p = static_cast<int>(out.size());
      out.emplace_back().groups.emplace_back();  // its ground
    }
    part[g] = p;
    number[g] = static_cast<int>(out[p].groups.size());
    out[p].groups.push_back(graph.groups[g]);
  }
  int grounded = -1;  // the part of joints between bodies that stand still: they must fit, and have outputs
  for (Edge edge : graph.edges) {
    int p = part[edge.group_a == 0 ? edge.group_b : edge.group_a];
    if (p < 0) {
      if (grounded < 0) {
        grounded = static_cast<int>(out.size());
        out.emplace_back().groups.emplace_back();
      }
      p = grounded;
    }
    edge.group_a = number[edge.group_a];
    edge.group_b = number[edge.group_b];
    out[p].edges.push_back(edge);
  }
  return out;
}

}  // namespace gelenk
