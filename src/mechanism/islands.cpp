// SPDX-License-Identifier: BSD-3-Clause
// Partition of a scene into islands, which can be solved separately, each with its own steps.
#include <algorithm>
#include <iterator>
#include <numeric>
#include <string_view>
#include <unordered_map>

#include "mechanism/graph.h"
#include "scene/formulas.h"
#include "scene/shapes.h"
#include "util/disjoint_sets.h"

namespace gelenk {
namespace {

// The groups of bodies at the ports of an element.
std::vector<int> groups_at(const ElementPlace& element, const BodyNumbers& number, const std::vector<int>& group_of,
                           const std::unordered_map<std::string_view, int>& moved_group) {
  std::vector<int> out;
  for (const BodyFrame& frame : element.frames) out.push_back(group_of[number(frame.body) + 1]);
  for (const std::string& joint : element.joints) {
    if (const auto found = moved_group.find(joint); found != moved_group.end()) out.push_back(found->second);
  }
  std::erase(out, 0);  // the ground does not couple islands
  return out;
}

// Couples what expressions do: the groups on which their elements act, those of the joints that they name, element
// states, which have the numbers after those of the groups, and named expressions after these.
void couple_by_expressions(const Scene& scene, std::size_t groups, const auto& groups_of, const auto& moved_group,
                           DisjointSets& sets) {
  const auto state = [&](std::string_view name) {
    const auto found = std::ranges::find(scene.states, name, &ElementState::name);
    return found == scene.states.end() ? -1 : static_cast<int>(groups) + static_cast<int>(found - scene.states.begin());
  };
  const auto expression = [&](std::string_view name) {
    const auto found = std::ranges::find(scene.expressions, name, &NamedExpression::name);
    const auto first = static_cast<int>(groups + scene.states.size());
    return found == scene.expressions.end() ? -1 : first + static_cast<int>(found - scene.expressions.begin());
  };
  const auto named = [&](std::string_view signal, std::vector<int>& coupled) {
    if (const int of = state(signal); of >= 0) coupled.push_back(of);
    const std::string_view owner = signal.substr(0, signal.find('.'));
    if (const auto moved = moved_group.find(owner); moved != moved_group.end()) coupled.push_back(moved->second);
    each_section(scene, [&](const Section&, const auto& elements) {
      const auto found = std::ranges::find_if(elements, [&](const auto& element) { return element.name == owner; });
      if (found != elements.end()) std::ranges::copy(groups_of(*found), std::back_inserter(coupled));
    });
  };
  for (const FormulaReader& reader : formula_readers(scene)) {
    std::vector<int> coupled;
    for (const std::string& signal : reader.signals) named(signal, coupled);
    if (coupled.empty()) continue;  // inputs and the time couple nothing
    for (const int of : {state(reader.place.name), expression(reader.place.name)}) {
      if (of >= 0) coupled.push_back(of);
    }
    for (const int group : groups_of(reader.place)) coupled.push_back(group);
    for (const int one : coupled) sets.join(coupled.front(), one);
  }
}

// Sets of groups, and of element states and named expressions after them, that are coupled.
DisjointSets coupled_groups(const Scene& scene, const Graph& graph) {
  DisjointSets sets(graph.groups.size() + scene.states.size() + scene.expressions.size());
  for (const Edge& edge : graph.edges) {
    if (edge.group_a != 0 && edge.group_b != 0) sets.join(edge.group_a, edge.group_b);
  }
  const BodyNumbers number(scene);
  std::vector<int> group_of(scene.bodies.size() + 1, 0);
  for (int g = 0; g < static_cast<int>(graph.groups.size()); ++g) {
    for (const int body : graph.groups[g].bodies) group_of[body + 1] = g;
  }
  std::unordered_map<std::string_view, int> moved_group;  // by joint: the group of one of its bodies, not the ground
  for (const Edge& edge : graph.edges) {
    moved_group[scene.joints[edge.scene_joint].name] = edge.group_a != 0 ? edge.group_a : edge.group_b;
  }
  // All groups at the ports of an element belong to one island.
  each_section(scene, [&](const Section&, const auto& elements) {
    for (const auto& element : elements) {
      const std::vector<int> groups = groups_at(element, number, group_of, moved_group);
      for (const int group : groups) sets.join(groups.front(), group);
    }
  });
  couple_by_expressions(
      scene, graph.groups.size(),
      [&](const ElementPlace& place) { return groups_at(place, number, group_of, moved_group); }, moved_group, sets);
  // So do all bodies that may touch others.
  const std::vector<bool> touches = bodies_that_touch(scene);
  int first = 0;
  for (std::size_t b = 0; b < touches.size(); ++b) {
    const int group = group_of[b + 1];
    if (!touches[b] || group == 0) continue;
    if (first == 0) first = group;
    sets.join(first, group);
  }
  return sets;
}

}  // namespace

std::vector<Graph> islands_of(const Scene& scene, const Graph& graph) {
  DisjointSets sets = coupled_groups(scene, graph);
  std::vector<Graph> out;
  std::vector<int> part_of_set(graph.groups.size() + scene.states.size() + scene.expressions.size(), -1);
  std::vector<int> part(graph.groups.size(), -1);   // by group
  std::vector<int> number(graph.groups.size(), 0);  // by group: its index in its part
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
  int grounded = -1;  // the part of joints between immobile bodies: they must be closed, and have outputs
  const auto ground_part = [&] {
    if (grounded < 0) {
      grounded = static_cast<int>(out.size());
      out.emplace_back().groups.emplace_back();
    }
    return grounded;
  };
  for (Edge edge : graph.edges) {
    int p = part[edge.group_a == 0 ? edge.group_b : edge.group_a];
    if (p < 0) p = ground_part();
    edge.group_a = number[edge.group_a];
    edge.group_b = number[edge.group_b];
    out[p].edges.push_back(edge);
  }
  const auto part_beyond = [&](std::size_t number) -> Graph& {
    const int p = part_of_set[sets.find(static_cast<int>(graph.groups.size() + number))];
    return out[p < 0 ? ground_part() : p];
  };
  for (int state : graph.states) part_beyond(static_cast<std::size_t>(state)).states.push_back(state);
  for (int expression : graph.expressions)
    part_beyond(scene.states.size() + static_cast<std::size_t>(expression)).expressions.push_back(expression);
  for (ContactEdge contact : graph.contacts) {
    const int p = part[contact.group_a == 0 ? contact.group_b : contact.group_a];
    contact.group_a = number[contact.group_a];
    contact.group_b = number[contact.group_b];
    out[p].contacts.push_back(contact);
  }
  return out;
}

std::vector<bool> observed_reactions(const Scene& scene) {
  std::vector<bool> out(scene.joints.size(), false);
  for (const Sensor& sensor : scene.sensors) {
    if (!kind_of(*sensor.is).reads_reaction) continue;
    const auto joint = std::ranges::find(scene.joints, sensor.joints.front(), &Joint::name);
    out[joint - scene.joints.begin()] = true;
  }
  return out;
}

Partition partition_of(const Scene& scene, const ImmobileJoints& immobile, std::vector<Note>& notes) {
  Partition out;
  out.whole = merge_welds(scene, observed_reactions(scene), immobile, notes);
  out.whole.states.resize(scene.states.size());
  std::iota(out.whole.states.begin(), out.whole.states.end(), 0);
  out.whole.expressions.resize(scene.expressions.size());
  std::iota(out.whole.expressions.begin(), out.whole.expressions.end(), 0);
  if (scene.solver.reduces(Reduction::islands)) {
    out.islands = islands_of(scene, out.whole);
  } else {
    out.islands.push_back(out.whole);
  }
  return out;
}

}  // namespace gelenk
