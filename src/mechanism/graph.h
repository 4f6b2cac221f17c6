// SPDX-License-Identifier: BSD-3-Clause
// The scene as a graph, for the reductions: groups of bodies welded together, and the joints between them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "joint/rod.h"
#include "mechanism/mechanism.h"
#include "scene/scene.h"

namespace gelenk {

struct Group {
  std::vector<int> bodies;  // of the scene
  std::vector<Pose3> X_GB;  // by member: pose of its frame in the group's
  Spatial::Inertia G;       // about the group's frame
  int half_of = -1;         // the group from which it has been split (split_bodies.cpp)
};

// A joint between two groups, with its canonical frames: X_AF in the parent's group, X_BM in the child's.
struct Edge {
  int scene_joint = -1;
  Stored<AnyJoint> joint;
  int group_a = 0, group_b = 0;
  Pose3 X_AF, X_BM;
  Eigen::Matrix3d R_UC = Eigen::Matrix3d::Identity();
  bool opposes_normal = false;  // planar: the user's axis is opposite to the plane's normal
  bool opens_beside = false;    // not that joint but the weld of a body that is split beside it
};

// A massless rod: a group without mass and its two joints, replaced by one loop-closing joint.
struct RodEdge {
  Rod joint;
  int group = 0;  // the rod
  Edge first, second;
  int group_a = 0, group_b = 0;  // the neighbors at these joints
  Pose3 X_AF{}, X_BM{};
};

// A contact between two groups: X_AF is the pose of the plane, X_BM that of the frame on the body.
struct ContactEdge {
  int constraint = -1;  // of the scene
  Stored<CutJoint> joint;
  int group_a = 0, group_b = 0;
  Pose3 X_AF, X_BM;
};

// Group 0 is the ground, with the world frame. Groups that have been replaced by rods have no edges.
struct Graph {
  std::vector<Group> groups;
  std::vector<Edge> edges;
  std::vector<RodEdge> rods;
  std::vector<ContactEdge> contacts;
  std::vector<int> states, expressions;  // element states and named expressions of the scene

  // The edges of each group, ascending.
  std::vector<std::vector<int>> edges_of_groups() const;
};

// Indices of bodies by name; the ground is -1.
class BodyNumbers {
 public:
  explicit BodyNumbers(const Scene& scene);
  int operator()(const std::string& name) const { return numbers_.at(name); }

 private:
  std::unordered_map<std::string, int> numbers_;
};

// --- the reductions, in the order of their application ---

// By joint of the scene: whether a sensor reads its reaction.
std::vector<bool> observed_reactions(const Scene& scene);

// Merges bodies connected by welds and immobile joints (weld.cpp). keep[j]: joint j remains a joint, because its
// reaction is read. Throws SceneError for welds that contradict each other.
Graph merge_welds(const Scene& scene, const std::vector<bool>& keep, const ImmobileJoints& immobile,
                  std::vector<Note>& notes);

// The islands: parts that are coupled by no joint, force or constraint, except through the ground (islands.cpp).
std::vector<Graph> islands_of(const Scene& scene, const Graph& graph);

// The graph of the scene, and the parts that are solved separately: its islands, or the whole graph if the reduction
// `islands` is off (islands.cpp).
struct Partition {
  Graph whole;
  std::vector<Graph> islands;
};
Partition partition_of(const Scene& scene, const ImmobileJoints& immobile, std::vector<Note>& notes);

// As reduce() in mechanism.h. rods_stay_bodies: by joint of the scene, whether massless rods in its island remain
// bodies; empty: in no island.
ReducedScene reduce(const Scene& scene, const ImmobileJoints& immobile, const std::vector<bool>& rods_stay_bodies);

// Names of the joints whose coordinates are constrained (constraints.cpp).
std::vector<std::string_view> constrained_joints(const Scene& scene);

// The contacts of the scene. group_of, X_GB: group and pose in it, by body + 1, with the ground first. Throws
// SceneError for a contact between bodies of one group (constraints.cpp).
std::vector<ContactEdge> contacts_of(const Scene& scene, const std::vector<int>& group_of,
                                     const std::vector<Pose3>& X_GB);

// The coordinate constraints between joints of the graph, whose positions are in places.joints; registers them in
// places.constraints. Throws SceneError if such a joint is immobile or is not in the tree (constraints.cpp).
std::vector<CoordinateRow> coordinate_rows(const Scene& scene, const Graph& graph, int island, ReducedScene& places);

// The plane of motion of a planar mechanism (plane.cpp).
struct MotionPlane {
  std::vector<Eigen::Vector3d> normals;  // by group, in its frame; empty if the mechanism is not planar
  std::string why_not;                   // a clause: "no joint axis defines a plane"
};
MotionPlane find_plane(const Scene& scene, const Graph& graph);

// Rotates all joint frames so that their z axes are along the normals.
void align_to_plane(Graph& graph, const std::vector<Eigen::Vector3d>& normals);

// Replaces massless groups that only keep two points at a distance by rods, if no element acts on them and the rest
// remains connected (massless.cpp). planar: the graph is aligned to a plane.
void replace_rods(const Scene& scene, bool planar, Graph& graph, std::vector<Note>& notes);

// Edges of the spanning tree in the order in which they reach new groups, from the ground (tree.cpp).
std::vector<int> spanning_tree(const Scene& scene, const Graph& graph, bool planar);
// Whether friction or a limit can keep a coordinate of the joint at rest, unless its rate would be a sum of velocities
// with constant factors.
bool must_not_be_cut(const Joint& joint, bool planar);

// The graph with bodies split where a loop cannot be cut otherwise, unless they have no mass (split_bodies.cpp).
Graph with_split_bodies(const Scene& scene, const Graph& graph, bool planar);

// Adds the shapes that can touch to the islands in which something can (shapes.cpp).
void add_shapes(const Scene& scene, ReducedScene& reduced);

// The mechanism of one island; registers bodies and joints in `places` (links.cpp). normal: of the plane, in the world,
// if the graph is aligned to one.
Mechanism make_mechanism(const Scene& scene, const Graph& graph, int island,
                         const std::optional<Eigen::Vector3d>& normal, ReducedScene& places);

}  // namespace gelenk
