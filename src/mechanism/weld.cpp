// SPDX-License-Identifier: BSD-3-Clause
// Bodies welded together become one.
#include <cmath>
#include <deque>

#include "mechanism/graph.h"

namespace gelenk {
namespace {

// Gaps of welds that close a loop of welds: rounding of a handful of products of numbers near 1 m and 1 rad.
constexpr double weld_gap = 1e-9;

bool merges(const Scene& scene, const std::vector<bool>& keep, int j) {
  return find_joint_kind(scene.joints[j].type)->nv == 0 && !keep[j];
}

Pose3 frame_in_group(const Graph& graph, const Scene& scene, const BodyFrame& frame) {
  const int body = body_index(scene, frame.body);
  return body < 0 ? frame.X_BF : graph.X_GB[body] * frame.X_BF;
}

// Gathers into the group what hangs on its last member by welds, breadth first.
struct Gatherer {
  const Scene& scene;
  const std::vector<bool>& keep;
  Graph& graph;

  void gather(int group, int first) const {  // first = -1: the ground
    std::deque<int> open = {first};
    while (!open.empty()) {
      const int body = open.front();
      open.pop_front();
      const std::string& name = body < 0 ? std::string(ground) : scene.bodies[body].name;
      for (int j = 0; j < static_cast<int>(scene.joints.size()); ++j) {
        if (!merges(scene, keep, j)) continue;
        const Joint& weld = scene.joints[j];
        if (weld.parent.body == name) join(group, body, weld.parent.X_BF, weld.child, open);
        if (weld.child.body == name) join(group, body, weld.child.X_BF, weld.parent, open);
      }
    }
  }

  void join(int group, int body, const Pose3& here, const BodyFrame& there, std::deque<int>& open) const {
    const int other = body_index(scene, there.body);
    if (other < 0 || graph.group_of[other] >= 0) return;
    const Pose3 X_GH = body < 0 ? here : graph.X_GB[body] * here;
    graph.group_of[other] = group;
    graph.X_GB[other] = X_GH * there.X_BF.inverse();
    graph.groups[group].bodies.push_back(other);
    open.push_back(other);
  }
};

Spatial::Inertia inertia_of(const Body& body) { return Spatial::Inertia::about_com(body.mass, body.com, body.inertia); }

// A weld inside a group must agree with the welds that made the group.
void check_weld(const Scene& scene, const Graph& graph, const Joint& weld, std::vector<std::string>& errors) {
  const Pose3 X = frame_in_group(graph, scene, weld.parent).inverse() * frame_in_group(graph, scene, weld.child);
  const double gap = X.p.norm();
  const double turn = rotation_vector(X.R).norm();
  if (gap <= weld_gap && turn <= weld_gap) return;
  errors.push_back((scene.file.empty() ? "" : scene.file + ": ") + "joints." + weld.name +
                   ": this weld contradicts other welds between '" + weld.parent.body + "' and '" + weld.child.body +
                   "': its two frames are " + std::to_string(gap) + " m and " + std::to_string(turn) +
                   " rad apart (allowed 1e-9); expected welds that agree");
}

Edge make_edge(const Scene& scene, const Graph& graph, int j) {
  const Joint& joint = scene.joints[j];
  Edge edge;
  edge.scene_joint = j;
  edge.joint = make_joint(joint.type, joint.axes);
  edge.R_UC = canonical_rotation(edge.joint, joint.axes);
  const Pose3 X_UC{edge.R_UC, Eigen::Vector3d::Zero()};
  const auto group = [&](const BodyFrame& frame) {
    const int body = body_index(scene, frame.body);
    return body < 0 ? 0 : graph.group_of[body];
  };
  edge.group_a = group(joint.parent);
  edge.group_b = group(joint.child);
  edge.X_AF = frame_in_group(graph, scene, joint.parent) * X_UC;
  edge.X_BM = frame_in_group(graph, scene, joint.child) * X_UC;
  return edge;
}

}  // namespace

int body_index(const Scene& scene, const std::string& name) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

Graph merge_welds(const Scene& scene, const std::vector<bool>& keep) {
  Graph graph;
  graph.group_of.assign(scene.bodies.size(), -1);
  graph.X_GB.resize(scene.bodies.size());
  const Gatherer gatherer{scene, keep, graph};
  graph.groups.emplace_back();
  gatherer.gather(0, -1);
  for (int body = 0; body < static_cast<int>(scene.bodies.size()); ++body) {
    if (graph.group_of[body] >= 0) continue;
    const int group = static_cast<int>(graph.groups.size());
    graph.groups.emplace_back();
    graph.groups[group].bodies.push_back(body);
    graph.group_of[body] = group;
    gatherer.gather(group, body);
  }
  for (std::size_t body = 0; body < scene.bodies.size(); ++body) {
    graph.groups[graph.group_of[body]].G += inertia_of(scene.bodies[body]).moved_by(graph.X_GB[body]);
  }
  std::vector<std::string> errors;
  for (int j = 0; j < static_cast<int>(scene.joints.size()); ++j) {
    if (merges(scene, keep, j)) {
      check_weld(scene, graph, scene.joints[j], errors);
    } else {
      graph.edges.push_back(make_edge(scene, graph, j));
    }
  }
  if (!errors.empty()) throw SceneError(errors);
  return graph;
}

}  // namespace gelenk
