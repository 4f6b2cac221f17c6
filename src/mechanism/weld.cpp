// SPDX-License-Identifier: BSD-3-Clause
// Merging of bodies that are connected by welds or immobile joints.
#include <algorithm>
#include <cmath>
#include <deque>

#include "mechanism/graph.h"
#include "util/text.h"

namespace gelenk {
namespace {

// Maximum closure error of a loop of welds: rounding of a few products of numbers near 1 m and 1 rad.
constexpr double weld_tolerance = 1e-9;  // m and rad

// A joint that fixes the relative pose of two bodies.
struct Weld {
  int joint;
  int a, b;    // bodies; -1: ground
  Pose3 X_AB;  // of b in a
};

Pose3 pose_at(const Joint& joint, const std::vector<double>& q) {
  const Pose3 X_UC{canonical_rotation(*joint.is, joint.axes), Eigen::Vector3d::Zero()};
  return X_UC * pose_across(*joint.is, q.data()) * X_UC.inverse();
}

struct GroupBuilder {
  const Scene& scene;
  BodyNumbers number{scene};
  Graph graph{};
  std::vector<Weld> welds{};
  std::vector<std::vector<int>> welds_of{};  // by body + 1
  std::vector<int> group_of{};               // by body + 1
  std::vector<Pose3> X_GB{};                 // by body + 1
  std::vector<bool> merged{};                // by scene joint

  void find_welds(const std::vector<bool>& keep, const ImmobileJoints& immobile) {
    welds_of.resize(scene.bodies.size() + 1);
    merged.assign(scene.joints.size(), false);
    for (int j = 0; j < static_cast<int>(scene.joints.size()); ++j) {
      const Joint& joint = scene.joints[j];
      const bool weld = find_joint_kind(joint.type)->nv == 0 && scene.solver.reduces(Reduction::weld);
      const bool is_immobile = !immobile.empty() && !immobile[j].empty();
      if (keep[j] || (!weld && !is_immobile)) continue;
      merged[j] = true;
      const Pose3 X_FM = is_immobile ? pose_at(joint, immobile[j]) : Pose3();
      const int a = number(joint.parent.body);
      const int b = number(joint.child.body);
      welds_of[a + 1].push_back(static_cast<int>(welds.size()));
      welds_of[b + 1].push_back(static_cast<int>(welds.size()));
      welds.push_back({j, a, b, joint.parent.X_BF * X_FM * joint.child.X_BF.inverse()});
    }
  }

  // Adds all bodies that are connected to `first` by welds to the group, breadth first.
  void gather(int group, int first) {
    std::deque<int> open = {first};
    group_of[first + 1] = group;
    while (!open.empty()) {
      const int body = open.front();
      open.pop_front();
      if (body >= 0) {
        graph.groups[group].bodies.push_back(body);
        graph.groups[group].X_GB.push_back(X_GB[body + 1]);
      }
      for (const int w : welds_of[body + 1]) {
        const Weld& weld = welds[w];
        const int other = weld.a == body ? weld.b : weld.a;
        if (group_of[other + 1] >= 0) continue;
        X_GB[other + 1] = X_GB[body + 1] * (weld.a == body ? weld.X_AB : weld.X_AB.inverse());
        group_of[other + 1] = group;
        open.push_back(other);
      }
    }
  }

  void make_groups() {
    group_of.assign(scene.bodies.size() + 1, -1);
    X_GB.resize(scene.bodies.size() + 1);
    graph.groups.emplace_back();
    gather(0, -1);
    for (int body = 0; body < static_cast<int>(scene.bodies.size()); ++body) {
      if (group_of[body + 1] >= 0) continue;
      graph.groups.emplace_back();
      gather(static_cast<int>(graph.groups.size()) - 1, body);
    }
    for (Group& group : graph.groups) {
      for (std::size_t i = 0; i < group.bodies.size(); ++i) {
        const Body& body = scene.bodies[group.bodies[i]];
        group.G += Spatial::Inertia::about_com(body.mass, body.com, body.inertia).moved_by(group.X_GB[i]);
      }
    }
  }

  // Throws SceneError unless redundant welds inside a group agree with the others.
  void check_welds() const {
    std::vector<std::string> errors;
    for (const Weld& weld : welds) {
      const Joint& joint = scene.joints[weld.joint];
      const Pose3 X = (X_GB[weld.a + 1] * weld.X_AB).inverse() * X_GB[weld.b + 1];
      const double gap = X.p.norm();
      const double turn = rotation_vector(X.R).norm();
      if (gap <= weld_tolerance && turn <= weld_tolerance) continue;
      errors.push_back((scene.file.empty() ? "" : scene.file + ": ") + "joints." + joint.name +
                       ": this weld contradicts other welds between '" + joint.parent.body + "' and '" +
                       joint.child.body + "': its two frames are " + std::to_string(gap) + " m and " +
                       std::to_string(turn) + " rad apart (allowed 1e-9); expected welds that agree");
    }
    if (!errors.empty()) throw SceneError(errors);
  }

  void make_edges() {
    for (int j = 0; j < static_cast<int>(scene.joints.size()); ++j) {
      if (merged[j]) continue;
      const Joint& joint = scene.joints[j];
      const int a = number(joint.parent.body);
      const int b = number(joint.child.body);
      Edge edge;
      edge.scene_joint = j;
      edge.joint = joint.is;
      edge.R_UC = canonical_rotation(*edge.joint, joint.axes);
      const Pose3 X_UC{edge.R_UC, Eigen::Vector3d::Zero()};
      edge.group_a = group_of[a + 1];
      edge.group_b = group_of[b + 1];
      edge.X_AF = X_GB[a + 1] * joint.parent.X_BF * X_UC;
      edge.X_BM = X_GB[b + 1] * joint.child.X_BF * X_UC;
      graph.edges.push_back(edge);
    }
    graph.contacts = contacts_of(scene, group_of, X_GB);
  }

  void report(const ImmobileJoints& immobile, std::vector<Note>& notes) const {
    std::vector<std::string> welded;
    std::vector<std::string> immobile_joints;
    for (const Weld& weld : welds) {
      const bool is_immobile = !immobile.empty() && !immobile[weld.joint].empty();
      (is_immobile ? immobile_joints : welded).push_back(scene.joints[weld.joint].name);
    }
    if (!welded.empty()) {
      const bool one = welded.size() == 1;
      notes.push_back({Reduction::weld, std::string(one ? "weld " : "welds ") + text::some(welded) +
                                            (one ? " merges" : " each merge") + " two bodies into one"});
    }
    if (!immobile_joints.empty()) {
      notes.push_back({Reduction::fixed, "immobile joints are treated as welds: " + text::some(immobile_joints)});
    }
    std::vector<std::string> immobile_bodies;
    for (const int body : graph.groups[0].bodies) immobile_bodies.push_back(scene.bodies[body].name);
    if (!immobile_bodies.empty()) {
      notes.push_back({Reduction::fixed, text::some(immobile_bodies) + (immobile_bodies.size() == 1 ? " is" : " are") +
                                             " fixed to the ground: removed from the equations"});
    }
  }
};

}  // namespace

BodyNumbers::BodyNumbers(const Scene& scene) {
  numbers_[ground] = -1;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) numbers_.emplace(scene.bodies[i].name, static_cast<int>(i));
}

std::vector<std::vector<int>> Graph::edges_of_groups() const {
  std::vector<std::vector<int>> out(groups.size());
  for (int e = 0; e < static_cast<int>(edges.size()); ++e) {
    out[edges[e].group_a].push_back(e);
    if (edges[e].group_b != edges[e].group_a) out[edges[e].group_b].push_back(e);
  }
  return out;
}

Graph merge_welds(const Scene& scene, const std::vector<bool>& keep, const ImmobileJoints& immobile,
                  std::vector<Note>& notes) {
  GroupBuilder builder{.scene = scene};
  builder.find_welds(keep, immobile);
  builder.make_groups();
  builder.check_welds();
  builder.make_edges();
  builder.report(immobile, notes);
  return std::move(builder.graph);
}

}  // namespace gelenk
