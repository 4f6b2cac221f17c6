// SPDX-License-Identifier: BSD-3-Clause
// The scene as a graph: groups of bodies welded together, and the joints between them.
#pragma once

#include <optional>
#include <vector>

#include "mechanism/mechanism.h"

namespace gelenk {

struct Group {
  std::vector<int> bodies;  // scene bodies; the ground's group is group 0
  Spatial::Inertia G;       // about the group's frame
};

// A joint between two groups, with its canonical frames: X_AF in the parent's group, X_BM in the child's.
struct Edge {
  int scene_joint = -1;
  AnyJoint joint;
  int group_a = 0, group_b = 0;
  Pose3 X_AF, X_BM;
  Eigen::Matrix3d R_UC = Eigen::Matrix3d::Identity();
};

struct Graph {
  std::vector<Group> groups;
  std::vector<Edge> edges;
  std::vector<int> group_of;  // by scene body
  std::vector<Pose3> X_GB;    // by scene body: its frame in its group's
};

// Index of a body in scene.bodies; -1 for the ground.
int body_index(const Scene& scene, const std::string& name);

// Merges welds (weld.cpp). keep[j]: joint j stays a joint even if it is a weld, because its reaction is asked for.
Graph merge_welds(const Scene& scene, const std::vector<bool>& keep);

// The plane's normal in each group's frame, if everything moves in one plane (plane.cpp).
std::optional<std::vector<Eigen::Vector3d>> plane_normals(const Graph& graph);

// Turns all joint frames so that their z axes lie along the normals. Returns by edge: the user's axis points
// against the normal.
std::vector<bool> align_to_plane(Graph& graph, const std::vector<Eigen::Vector3d>& normals);

// Edges of the spanning tree in the order in which they reach new groups, from the ground (tree.cpp).
std::vector<int> spanning_tree(const Scene& scene, const Graph& graph);

}  // namespace gelenk
