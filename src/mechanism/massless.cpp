// SPDX-License-Identifier: BSD-3-Clause
// Massless rods between two joints that allow any direction are replaced by one constraint equation each: the distance
// between their ends.
#include <algorithm>
#include <string>
#include <string_view>
#include <type_traits>
#include <unordered_set>

#include "joint/isotropic_friction.h"
#include "joint/swing_limit.h"
#include "mechanism/graph.h"
#include "scene/formulas.h"
#include "scene/shapes.h"
#include "util/disjoint_sets.h"
#include "util/text.h"

namespace gelenk {
namespace {

bool has_inertia(const Group& group) { return group.G.m != 0 || !group.G.I.isZero(0); }

// The bodies and joints on which elements act, and the joints whose reaction is read.
class InteractionIndex {
 public:
  explicit InteractionIndex(const Scene& scene) : scene_(scene) {
    named_ = named_of_motion(scene);
    each_section(scene, [&](const Section&, const auto& elements) {
      for (const auto& element : elements) enter(element, kind_of(*element.is));
    });
    const std::vector<bool> touches = bodies_that_touch(scene);
    for (std::size_t b = 0; b < touches.size(); ++b) {
      if (touches[b]) bodies_.insert(scene.bodies[b].name);
    }
  }

  // Whether an element acts along the joint or may be tuned to do so, or the reaction there is read, or a coordinate by
  // an expression.
  bool at(const Edge& edge) const {
    const Joint& joint = scene_.joints[edge.scene_joint];
    return joints_.contains(joint.name) || named_.contains(joint.name) || !joint.is_idle() ||
           swing_limit_of(*joint.is) != nullptr || !friction_parts_of(*joint.is).empty() || may_be_tuned(joint.name);
  }
  // Whether an element acts on one of the bodies.
  bool on(const Group& group) const {
    return std::ranges::any_of(group.bodies, [&](int b) { return bodies_.contains(scene_.bodies[b].name); });
  }

 private:
  // Sensors do not affect the motion, if no expression names them, but a reaction that is read requires its joint, and
  // an acceleration its body.
  template <class Any>
  void enter(const Element<Any>& element, const ElementKind& kind) {
    const bool acts = !std::is_same_v<Any, AnySensor> || named_.contains(element.name);
    for (const std::string& joint : element.joints) {
      if (acts || kind.reads_reaction) joints_.insert(joint);
    }
    for (const BodyFrame& frame : element.frames) {
      if (acts || kind.reads_acceleration) bodies_.insert(frame.body);
    }
  }

  // Whether a tunable field of a force along the joint, or an element of it, is listed as a parameter.
  bool may_be_tuned(const std::string& joint) const {
    return std::ranges::any_of(scene_.parameters, [&](const std::string& listed) {
      if (!listed.starts_with(joint + ".")) return false;
      const std::string_view field = std::string_view(listed).substr(joint.size() + 1);
      for (const JointForceKind& force : joint_force_kinds()) {
        for (const Field& f : force.fields) {
          if (f.tunable && force.group.empty() && field.substr(0, field.find('[')) == f.name) return true;
        }
      }
      return false;
    });
  }

  const Scene& scene_;
  std::unordered_set<std::string_view> joints_, bodies_;
  std::unordered_set<std::string> named_;  // joints and sensors
};

bool starts_fixed(const Joint& joint) {
  return std::ranges::find(joint.start.q_fixed, true) != joint.start.q_fixed.end() ||
         std::ranges::find(joint.start.v_fixed, true) != joint.start.v_fixed.end();
}

struct RodReduction {
  const Scene& scene;
  bool planar;
  Graph& graph;
  InteractionIndex interactions{scene};
  std::vector<RodEdge> candidates{};

  void run() {
    const auto edges_of = graph.edges_of_groups();
    for (int g = 1; g < static_cast<int>(graph.groups.size()); ++g) {
      if (edges_of[g].size() == 2) try_rod(g, graph.edges[edges_of[g][0]], graph.edges[edges_of[g][1]]);
    }
    keep_connected();
    std::vector<bool> removed(graph.groups.size(), false);
    for (const RodEdge& rod : candidates) removed[rod.group] = true;
    std::erase_if(graph.edges, [&](const Edge& edge) { return removed[edge.group_a] || removed[edge.group_b]; });
    graph.rods = std::move(candidates);
  }

  // A massless neighbor gets its inertia through the rod, which must then remain a body.
  bool can_carry_rod(int group) const { return group == 0 || graph.groups[group].G.m != 0; }

  void try_rod(int g, const Edge& one, const Edge& other) {
    const Group& group = graph.groups[g];
    if (has_inertia(group) || interactions.on(group) || interactions.at(one) || interactions.at(other)) return;
    const int a = one.group_a == g ? one.group_b : one.group_a;
    const int b = other.group_a == g ? other.group_b : other.group_a;
    if (a == b || !can_carry_rod(a) || !can_carry_rod(b)) return;
    if (!add(g, one, other)) add(g, other, one);
  }

  bool add(int g, const Edge& first, const Edge& second) {
    const bool first_reversed = first.group_a == g;  // M, not F, is on the neighbor
    const bool second_reversed = second.group_a != g;
    const Pose3 X_12 =
        (first_reversed ? first.X_AF : first.X_BM).inverse() * (second_reversed ? second.X_BM : second.X_AF);
    const auto joint = make_rod(*first.joint, first_reversed, *second.joint, second_reversed, X_12, planar);
    if (!joint) return false;
    // The fixed start value of a joint could not be satisfied if the rod may spin about its own axis.
    if (joint->has_free_spin() &&
        (starts_fixed(scene.joints[first.scene_joint]) || starts_fixed(scene.joints[second.scene_joint])))
      return false;
    RodEdge rod{.joint = *joint, .group = g, .first = first, .second = second};
    rod.group_a = first_reversed ? first.group_b : first.group_a;
    rod.X_AF = first_reversed ? first.X_BM : first.X_AF;
    rod.group_b = second_reversed ? second.group_a : second.group_b;
    rod.X_BM = second_reversed ? second.X_AF : second.X_BM;
    // Planar algebra has no heights: a slanted rod is replaced by its projection.
    if (planar) rod.X_BM.p -= X_12.p.z() * rod.X_BM.R.col(2);
    candidates.push_back(rod);
    return true;
  }

  // A rod without which a part would be disconnected remains a body: its joints have fewer states than the six
  // velocities of a free part with a constraint equation. Such a rod must not be free to spin about its axis, since it
  // has no inertia.
  void keep_connected() {
    DisjointSets sets(graph.groups.size());
    std::vector<bool> is_rod(graph.groups.size(), false);
    for (const RodEdge& rod : candidates) is_rod[rod.group] = true;
    const auto join_joints = [&](bool that_hold) {
      for (const Edge& edge : graph.edges) {
        const bool holds = kind_of(*edge.joint).nv < (planar ? 3 : 6);
        if (holds == that_hold && !is_rod[edge.group_a] && !is_rod[edge.group_b]) sets.join(edge.group_a, edge.group_b);
      }
    };
    std::vector<RodEdge> in_loops;
    const auto join_rods = [&](bool that_spin) {
      for (const RodEdge& rod : candidates) {
        if (rod.joint.has_free_spin() == that_spin && !sets.join(rod.group_a, rod.group_b)) in_loops.push_back(rod);
      }
    };
    join_joints(true);
    join_rods(false);
    join_joints(false);
    join_rods(true);
    candidates = std::move(in_loops);
  }

  void report(std::vector<Note>& notes) const {
    std::vector<std::string> rods;
    for (const RodEdge& rod : graph.rods) {
      const auto joint = [&](const Edge& edge) {
        const Joint& j = scene.joints[edge.scene_joint];
        return j.type + " " + j.name;
      };
      const Group& group = graph.groups[rod.group];
      rods.push_back(scene.bodies[group.bodies.front()].name + " (" + joint(rod.first) + ", " + joint(rod.second) +
                     ")");
    }
    if (rods.empty()) return;
    const bool one = rods.size() == 1;
    notes.push_back({Reduction::massless, std::string(one ? "massless rod " : "massless rods ") + text::some(rods) +
                                              (one ? ": replaced by one distance constraint"
                                                   : ": each replaced by one distance constraint")});
  }
};

}  // namespace

void replace_rods(const Scene& scene, bool planar, Graph& graph, std::vector<Note>& notes) {
  RodReduction reduction{.scene = scene, .planar = planar, .graph = graph};
  reduction.run();
  reduction.report(notes);
}

}  // namespace gelenk
