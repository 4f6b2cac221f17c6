// SPDX-License-Identifier: BSD-3-Clause
// Test for planar motion.
#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <utility>

#include "element/locking.h"
#include "joint/isotropic_friction.h"
#include "mechanism/graph.h"

namespace gelenk {
namespace {

// Sine of the largest angle between an axis and its direction in a planar mechanism. Frames computed by the user's own
// program have rounding errors of about 1e-16 per rotation; an intended misalignment is far larger.
constexpr double max_misalignment = 1e-11;

PlanarRole role(const Edge& edge) { return kind_of(*edge.joint).planar; }
bool has_axis(const Edge& edge) { return kind_of(*edge.joint).axes > 0; }

// A candidate for the normal: (group, direction in the group's frame).
std::optional<std::pair<int, Eigen::Vector3d>> candidate(const Graph& graph) {
  for (const Edge& edge : graph.edges) {
    if (role(edge) == PlanarRole::normal && has_axis(edge)) return {{edge.group_a, edge.X_AF.R.col(2)}};
  }
  // Only prismatic joints: groups do not rotate, so all axes on one group can be compared.
  for (const Edge& first : graph.edges) {
    for (const Edge& second : graph.edges) {
      if (first.group_a != second.group_a) continue;
      const Eigen::Vector3d n = first.X_AF.R.col(2).cross(second.X_AF.R.col(2));
      if (n.norm() > 0.01) return {{first.group_a, n.normalized()}};
    }
  }
  if (graph.edges.empty() || role(graph.edges[0]) != PlanarRole::in_plane) return std::nullopt;
  return {{graph.edges[0].group_a, graph.edges[0].X_AF.R.col(0)}};
}

// Whether the axis of the joint is compatible with the normal n_F, given in F.
bool fits(const Edge& edge, const Eigen::Vector3d& n_F) {
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  if (!has_axis(edge)) return true;
  if (role(edge) == PlanarRole::normal) return n_F.cross(axis).norm() <= max_misalignment;
  return std::abs(n_F.dot(axis)) <= max_misalignment;
}

// The joint of a guide whose friction depends on the force across it, out of the plane, too; empty: there is none. In a
// closed loop, no equations of the plane's mechanism determine that force, unless nothing acts out of the plane.
std::string loaded_guide(const Scene& scene, const Graph& graph, const MotionPlane& plane) {
  constexpr double in_plane = 1e-11;  // of gravity
  const bool has_loops = graph.edges.size() >= graph.groups.size();
  if (has_loops && !scene.gravity_field &&
      std::abs(plane.normals[0].dot(scene.gravity)) <= in_plane * scene.gravity.norm())
    return {};
  for (const Edge& edge : graph.edges) {
    const Joint& joint = scene.joints[edge.scene_joint];
    if (std::ranges::any_of(joint.along, is_loaded_guide, &Stored<JointForces>::value)) return joint.name;
  }
  return {};
}

// Why a joint of this name is in no plane; empty: it may be.
std::string not_planar(const Edge& edge, const std::string& name) {
  if (role(edge) == PlanarRole::never)
    return "joint " + name + " (" + std::string(kind_of(*edge.joint).name) + ") permits motion out of any plane";
  if (friction_parts_of(*edge.joint).empty()) return {};
  return "the friction of joint " + name + " is solved for as that of a contact, in space";
}

}  // namespace

MotionPlane find_plane(const Scene& scene, const Graph& graph) {
  const auto name = [&](const Edge& edge) { return scene.joints[edge.scene_joint].name; };
  const auto none = [](std::string why) { return MotionPlane{.normals = {}, .why_not = std::move(why)}; };
  for (const Edge& edge : graph.edges) {
    if (std::string why = not_planar(edge, name(edge)); !why.empty()) return none(std::move(why));
  }
  const auto start = candidate(graph);
  if (!start) return none("no joint axis defines a plane");
  MotionPlane plane;
  plane.normals.assign(graph.groups.size(), Eigen::Vector3d::Zero());
  const auto edges_of = graph.edges_of_groups();
  std::deque<int> open = {start->first};
  plane.normals[start->first] = start->second;
  while (!open.empty()) {
    const int group = open.front();
    open.pop_front();
    for (const int e : edges_of[group]) {
      const Edge& edge = graph.edges[e];
      const bool from_a = edge.group_a == group;
      const Pose3& here = from_a ? edge.X_AF : edge.X_BM;
      const Pose3& there = from_a ? edge.X_BM : edge.X_AF;
      const int other = from_a ? edge.group_b : edge.group_a;
      const Eigen::Vector3d n_F = here.R.transpose() * plane.normals[group];
      if (!fits(edge, n_F))
        return none("the axis of joint " + name(edge) + " is not aligned with the plane of the others");
      // The joint rotates about n or not at all, so that n has the same components in F and in M.
      const Eigen::Vector3d n = there.R * n_F;
      if (plane.normals[other].isZero(0)) {
        plane.normals[other] = n.normalized();
        open.push_back(other);
      } else if ((plane.normals[other] - n).norm() > max_misalignment) {
        return none("the two frames of joint " + name(edge) + " are tilted relative to each other");
      }
    }
  }
  if (const std::string guide = loaded_guide(scene, graph, plane); !guide.empty())
    return none("the friction of joint " + guide + " depends on forces out of the plane");
  return plane;
}

void align_to_plane(Graph& graph, const std::vector<Eigen::Vector3d>& normals) {
  for (Edge& edge : graph.edges) {
    const Eigen::Vector3d n_F = edge.X_AF.R.transpose() * normals[edge.group_a];
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    if (!has_axis(edge)) {
      turn = rotation_taking_z_to(n_F.normalized());
    } else if (role(edge) == PlanarRole::normal) {
      edge.opposes_normal = n_F.z() < 0;
      if (edge.opposes_normal) turn = Eigen::Vector3d(1, -1, -1).asDiagonal();
    } else {  // prismatic axis along x, normal along z
      turn.col(0) = Eigen::Vector3d::UnitZ();
      turn.col(2) = Eigen::Vector3d(n_F.x(), n_F.y(), 0).normalized();
      turn.col(1) = turn.col(2).cross(turn.col(0));
    }
    edge.R_UC = edge.R_UC * turn;
    edge.X_AF.R = edge.X_AF.R * turn;
    edge.X_BM.R = edge.X_BM.R * turn;
  }
}

}  // namespace gelenk
