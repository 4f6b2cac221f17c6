// SPDX-License-Identifier: BSD-3-Clause
// Applies the reductions in their order, from the scene to its islands.
#include <algorithm>
#include <cmath>

#include "mechanism/graph.h"
#include "scene/component_parts.h"
#include "scene/shapes.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Maximum height difference of the two frames of a cut joint in a planar mechanism, whose algebra has no heights.
constexpr double height_tolerance = 1e-9;  // m

const Cut* cut_at_two_heights(const Mechanism& mechanism) {
  for (const Cut& cut : mechanism.cuts) {
    const double a = mechanism.heights[cut.link_a] + cut.X_AF.p.z();
    const double b = mechanism.heights[cut.link_b] + cut.X_BM.p.z();
    if (!(std::abs(a - b) <= height_tolerance)) return &cut;
  }
  return nullptr;
}

std::string joints_in(const Scene& scene, const Graph& graph) {
  std::vector<std::string> names;
  for (const Edge& edge : graph.edges) names.push_back(scene.joints[edge.scene_joint].name);
  return text::some(names);
}

struct Reducer {
  const Scene& scene;
  std::vector<bool> observed;
  std::vector<bool> touches;  // by body: whether it has shapes that can touch others
  const std::vector<bool>& rods_stay_bodies;
  ReducedScene out{};

  void note(Reduction pass, const std::string& text, bool changed = true) {
    out.notes.push_back({pass, text, changed});
  }

  // The name of a joint whose reaction is read, or nothing. Reactions require spatial algebra, since planar algebra has
  // no forces along the normal.
  std::string observed_reaction(const Graph& graph) const {
    for (const Edge& edge : graph.edges) {
      if (observed[edge.scene_joint]) return scene.joints[edge.scene_joint].name;
    }
    return {};
  }

  // The name of a body with shapes that can touch others, or nothing.
  std::string touching_body(const Graph& graph) const {
    for (const Group& group : graph.groups) {
      for (const int body : group.bodies) {
        if (touches[static_cast<std::size_t>(body)]) return scene.bodies[static_cast<std::size_t>(body)].name;
      }
    }
    return {};
  }

  bool may_replace_rods(const Graph& graph) const {
    const auto stays_body = [&](const Edge& edge) { return rods_stay_bodies[edge.scene_joint]; };
    return scene.solver.reduces(Reduction::massless) &&
           (rods_stay_bodies.empty() || std::ranges::none_of(graph.edges, stays_body));
  }

  void add_island(const Graph& graph) {
    if (!add_planar(graph)) {
      const int island = static_cast<int>(out.islands.size());
      Graph in_space = graph;
      if (may_replace_rods(graph)) replace_rods(scene, false, in_space, out.notes);
      out.islands.push_back(
          make_mechanism(scene, with_split_bodies(scene, in_space, false), island, std::nullopt, out));
    }
    check_drives(graph);
    report_cuts(out.islands.back());
  }

  bool add_planar(const Graph& graph) {
    if (!scene.solver.reduces(Reduction::planar) || graph.edges.empty()) return false;
    const auto in_space = [&](const std::string& why) {
      note(Reduction::planar, "not planar: " + why, false);
      return false;
    };
    if (const std::string joint = observed_reaction(graph); !joint.empty()) {
      return in_space("the reaction of joint " + joint + " is an output, which requires spatial algebra");
    }
    if (!graph.contacts.empty()) {
      return in_space("constraint " + scene.constraints[graph.contacts.front().constraint].name +
                      " requires spatial algebra");
    }
    if (const std::string body = touching_body(graph); !body.empty()) {
      return in_space("the shapes of body " + body + " can touch others, which requires spatial algebra");
    }
    const MotionPlane plane = find_plane(scene, graph);
    if (plane.normals.empty()) return in_space(plane.why_not);
    Graph aligned = graph;
    align_to_plane(aligned, plane.normals);
    std::vector<Note> rods;
    if (may_replace_rods(graph)) replace_rods(scene, true, aligned, rods);
    const int island = static_cast<int>(out.islands.size());
    const Eigen::Vector3d& n = plane.normals[0];
    Mechanism mechanism = make_mechanism(scene, with_split_bodies(scene, aligned, true), island, n, out);
    if (const Cut* cut = cut_at_two_heights(mechanism)) {
      return in_space("the two frames of joint " + scene.joints[cut->scene_joints.front()].name +
                      " are at different heights above the plane");
    }
    note(Reduction::planar, joints_in(scene, graph) + ": all motion is perpendicular to (" + text::rounded(n.x(), 4) +
                                ", " + text::rounded(n.y(), 4) + ", " + text::rounded(n.z(), 4) +
                                "), so velocities and forces have 3 components instead of 6");
    out.notes.insert(out.notes.end(), rods.begin(), rods.end());
    out.islands.push_back(std::move(mechanism));
    return true;
  }

  void check_drives(const Graph& graph) const {
    std::vector<std::string> errors;
    for (const DrivenJoint& driven : driven_joints(scene)) {
      if (driven.inertia == 0) continue;
      for (const Edge& edge : graph.edges) {
        const int j = edge.scene_joint;
        if (scene.joints[j].name != driven.joint || out.joints[j].role == JointPlace::Role::tree) continue;
        errors.push_back(
            (scene.file.empty() ? "" : scene.file + ": ") + driven.path + ": found an inertia of " +
            text::number(driven.inertia) +
            " kg m2 in a loop in which every joint has a motor with inertia; expected an inertia of 0 at one joint "
            "of each loop (add the rotor's inertia to a body there)");
      }
    }
    if (!errors.empty()) throw SceneError(errors);
  }

  void report_cuts(const Mechanism& mechanism) {
    if (!scene.solver.reduces(Reduction::cut_choice)) return;
    std::vector<std::string> names;
    for (const Cut& cut : mechanism.cuts) {
      if (cut.is_rod() || cut.is_contact()) continue;
      const Joint& joint = scene.joints[cut.scene_joints.front()];
      names.push_back(cut.opens_beside ? "a body at " + joint.name : joint.name + " (" + joint.type + ")");
    }
    if (names.empty()) return;
    note(Reduction::cut_choice,
         "loops are cut at " + text::some(names) +
             ", which gives the fewest constraint equations and quaternions and leaves driven joints uncut");
  }
};

}  // namespace

ReducedScene reduce(const Scene& scene, const ImmobileJoints& immobile) { return reduce(scene, immobile, {}); }

ReducedScene reduce(const Scene& scene, const ImmobileJoints& immobile, const std::vector<bool>& rods_stay_bodies) {
  Reducer reducer{.scene = scene,
                  .observed = observed_reactions(scene),
                  .touches = bodies_that_touch(scene),
                  .rods_stay_bodies = rods_stay_bodies};
  ReducedScene& out = reducer.out;
  out.bodies.resize(scene.bodies.size());
  out.joints.resize(scene.joints.size());
  out.constraints.resize(scene.constraints.size());
  if (!immobile.empty()) {
    for (std::size_t j = 0; j < immobile.size(); ++j) out.joints[j].q = immobile[j];
  }
  const auto [graph, parts] = partition_of(scene, immobile, out.notes);
  if (parts.size() > 1) {
    reducer.note(Reduction::islands,
                 std::to_string(parts.size()) + " uncoupled islands, each integrated with its own steps");
  }
  for (const Graph& part : parts) reducer.add_island(part);
  const Group& immobile_group = graph.groups[0];
  for (std::size_t i = 0; i < immobile_group.bodies.size(); ++i)
    out.bodies[immobile_group.bodies[i]] = {-1, 0, immobile_group.X_GB[i], -1};
  add_shapes(scene, out);
  return std::move(reducer.out);
}

Mechanism with_rows(const Mechanism& mechanism, const std::vector<std::vector<int>>& kept) {
  Mechanism out = mechanism;
  out.rows = 0;
  for (std::size_t c = 0; c < out.cuts.size(); ++c) {
    Cut& cut = out.cuts[c];
    cut.kept = kept[c];
    cut.rows = static_cast<int>(cut.kept.size());
    cut.first_row = out.rows;
    out.rows += cut.rows;
  }
  out.rows += static_cast<int>(out.coordinate_rows.size());
  return out;
}

Mechanism without_drives(const Mechanism& mechanism) {
  Mechanism out = mechanism;
  out.rows -=
      static_cast<int>(std::erase_if(out.coordinate_rows, [](const CoordinateRow& row) { return row.moves(); }));
  return out;
}

std::vector<bool> Mechanism::position_rows() const {
  std::vector<bool> out;
  for (const Cut& cut : cuts) {
    for (const int i : cut.kept) out.push_back(holds_position(*cut.joint, i));
  }
  for (const CoordinateRow& row : coordinate_rows) out.push_back(row.holds_position);
  return out;
}

BodyPlace place(const Scene& scene, const ReducedScene& reduced, int island, const BodyFrame& frame) {
  const auto in_ground_link = [&](const Pose3& X_WB) {
    const Pose3 X_0B = island < 0 ? X_WB : reduced.islands[island].X_W0.inverse() * X_WB;
    return BodyPlace{island, 0, X_0B, -1};
  };
  if (frame.body == ground) return in_ground_link(frame.X_BF);
  const auto body = std::ranges::find(scene.bodies, frame.body, &Body::name);
  BodyPlace found = reduced.bodies[body - scene.bodies.begin()];
  found.X_LB = found.X_LB * frame.X_BF;
  return found.island < 0 ? in_ground_link(found.X_LB) : found;
}

}  // namespace gelenk
