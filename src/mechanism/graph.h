// SPDX-License-Identifier: BSD-3-Clause
// The scene as a graph: groups of bodies that move as one, and the joints between them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "mechanism/mechanism.h"

namespace gelenk {

struct Group {
  std::vector<int> bodies;  // of the scene
  std::vector<Pose3> X_GB;  // by member: its frame in the group's
  Spatial::Inertia G;       // about the group's frame
};

// A joint between two groups, with its canonical frames: X_AF in the parent's group, X_BM in the child's.
struct Edge {
  int scene_joint = -1;
  AnyJoint joint;
  int group_a = 0, group_b = 0;
  Pose3 X_AF, X_BM;
  Eigen::Matrix3d R_UC = Eigen::Matrix3d::Identity();
  bool against = false;  // planar: the user's axis points against the plane's normal
};

// A group without mass and the two joints that hold it, as one joint that closes a loop.
struct RodEdge {
  Rod joint;
  int group = 0;  // the rod's
  Edge first, second;
  int group_a = 0, group_b = 0;  // the neighbours at these
  Pose3 X_AF{}, X_BM{};
};

// A contact between two groups: X_AF of the plane, X_BM of the body on it.
struct ContactEdge {
  int constraint = -1;  // of the scene
  CutJoint joint;
  int group_a = 0, group_b = 0;
  Pose3 X_AF, X_BM;
};

// Group 0 is the ground, its frame the world. Groups that have become rods have no edges.
struct Graph {
  std::vector<Group> groups;
  std::vector<Edge> edges;
  std::vector<RodEdge> rods;
  std::vector<ContactEdge> contacts;

  // By group: its edges, ascending.
  std::vector<std::vector<int>> edges_of_groups() const;
};

// Numbers of bodies by name; the ground is -1.
class BodyNumbers {
 public:
  explicit BodyNumbers(const Scene& scene);
  int operator()(const std::string& name) const { return numbers_.at(name); }

 private:
  std::unordered_map<std::string, int> numbers_;
};

// --- the passes, in this order ---

// By joint of the scene: a sensor reads its reaction.
std::vector<bool> observed_reactions(const Scene& scene);

// Merges welds and joints that stand still (weld.cpp). keep[j]: joint j stays a joint, because its reaction is asked
// for.
Graph merge_welds(const Scene& scene, const std::vector<bool>& keep, const ImmobileJoints& immobile,
                  std::vector<Note>& notes);

// Parts that neither joints nor forces couple, except through the ground (islands.cpp).
std::vector<Graph> islands_of(const Scene& scene, const Graph& graph);

// The scene's groups, and the parts that are solved apart: its islands, or all of it where they are switched off
// (islands.cpp).
struct Parts {
  Graph whole;
  std::vector<Graph> islands;
};
Parts parts_of(const Scene& scene, const ImmobileJoints& immobile, std::vector<Note>& notes);

// As reduce() in mechanism.h. rods_stay_bodies: by joint of the scene, in its island rods without mass do; empty: in
// none.
ReducedScene reduce(const Scene& scene, const ImmobileJoints& immobile, const std::vector<bool>& rods_stay_bodies);

// Joints whose coordinates constraints name (constraints.cpp).
std::vector<std::string_view> constrained_joints(const Scene& scene);

// The contacts of the scene, given where its bodies are: by body + 1, the ground first. Throws SceneError for one
// within a rigid body (constraints.cpp).
std::vector<ContactEdge> contacts_of(const Scene& scene, const std::vector<int>& group_of,
                                     const std::vector<Pose3>& X_GB);

// The rows in joints' coordinates of the constraints between joints of the graph, given where these have gone; entered
// into `places`. Throws SceneError where such a joint is not in the tree (constraints.cpp).
std::vector<CoordinateRow> coordinate_rows(const Scene& scene, const Graph& graph, int island, ReducedScene& places);

// Does everything move in one plane? (plane.cpp)
struct Plane {
  std::vector<Eigen::Vector3d> normals;  // by group, in its frame; empty if there is no plane
  std::string why_not;                   // a clause: "joint A turns about an axis across ..."
};
Plane find_plane(const Scene& scene, const Graph& graph);

// Turns all joint frames so that their z axes lie along the normals.
void align_to_plane(Graph& graph, const std::vector<Eigen::Vector3d>& normals);

// Makes rods of groups without mass that only keep two points at a distance, where nothing acts on them and the rest
// stays connected (massless.cpp). planar: the graph is aligned to a plane.
void replace_rods(const Scene& scene, bool planar, Graph& graph, std::vector<Note>& notes);

// Edges of the spanning tree in the order in which they reach new groups, from the ground (tree.cpp).
std::vector<int> spanning_tree(const Scene& scene, const Graph& graph);

// The links, cuts and places of one part (links.cpp). normal: of the plane in the world, if the graph is aligned to
// one.
Mechanism make_mechanism(const Scene& scene, const Graph& graph, int island,
                         const std::optional<Eigen::Vector3d>& normal, ReducedScene& places);

}  // namespace gelenk
