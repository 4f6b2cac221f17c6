// SPDX-License-Identifier: BSD-3-Clause
// From the scene's constraints to contacts between groups and rows in joints' coordinates.
#include <algorithm>
#include <string_view>
#include <unordered_map>

#include "mechanism/graph.h"
#include "scene/units.h"

namespace gelenk {
namespace {

bool is_contact(const Constraint& c) {
  return c.type == ConstraintType::rolling || c.type == ConstraintType::knife_edge;
}

// "scene.yaml: constraints.mesh: ".
std::string at(const Scene& scene, const Constraint& c) {
  return (scene.file.empty() ? "" : scene.file + ": ") + "constraints." + c.name + ": ";
}

// From a frame's axes to such with z along the unit vector `axis`.
Pose3 with_z_along(const Eigen::Vector3d& axis) { return {rotation_taking_z_to(axis), Eigen::Vector3d::Zero()}; }

struct RowMaker {
  const Scene& scene;
  const Graph& graph;
  int island;
  ReducedScene& places;
  std::unordered_map<std::string_view, int> in_graph{};         // scene joint by name
  std::unordered_map<std::string_view, const Edge*> edge_of{};  // by joint
  std::vector<CoordinateRow> out{};
  std::vector<std::string> errors{};

  void run() {
    for (const Edge& edge : graph.edges) {
      const std::string& name = scene.joints[edge.scene_joint].name;
      in_graph.emplace(name, edge.scene_joint);
      edge_of.emplace(name, &edge);
    }
    for (const bool moves : {false, true}) {  // those that stand still first
      int input = load_input_count(scene);
      for (int c = 0; c < static_cast<int>(scene.constraints.size()); ++c) {
        const Constraint& constraint = scene.constraints[c];
        const bool motion = constraint.type == ConstraintType::motion;
        const int its_input = motion && constraint.motion.is_input() ? input++ : -1;
        if (is_contact(constraint) || motion != moves || !in_graph.contains(constraint.joint)) continue;
        places.constraints[c] = {island, -1, static_cast<int>(out.size())};
        CoordinateRow row = motion ? motion_row(constraint) : gear_row(constraint);
        row.constraint = c;
        row.input = its_input;
        out.push_back(std::move(row));
      }
    }
    if (!errors.empty()) throw SceneError(errors);
  }

  CoordinateRow motion_row(const Constraint& c) {
    CoordinateRow row;
    const JointKind& kind = *find_joint_kind(scene.joints[in_graph.at(c.joint)].type);
    const int component = motion_signals(kind, c).component;
    add_term(row, c, c.joint, component, 1);
    row.is_angle = kind.q[component].unit == "rad";
    row.holds_position = !c.motion.speed_only();
    if (!c.motion.is_input()) row.law.emplace(c.motion);
    return row;
  }

  // phi_a - phi_c - ratio (phi_b - phi_c) = offset, phi_c left out where a joint hangs on the carrier itself: its angle
  // is against it already.
  CoordinateRow gear_row(const Constraint& c) {
    CoordinateRow row;
    add_term(row, c, c.joint, 0, 1);
    add_term(row, c, c.other, 0, -c.ratio);
    if (!c.carrier.empty() && moves(c, c.other) && moves(c, c.carrier)) {
      const double factor = (on_base(c, c.other) ? c.ratio : 0) - (on_base(c, c.joint) ? 1 : 0);
      if (factor != 0) add_term(row, c, c.carrier, 0, factor);
    }
    row.is_angle = c.type == ConstraintType::gear;
    row.constant = c.offset;
    return row;
  }

  // A joint between bodies that stand still is in no part that moves.
  bool moves(const Constraint& c, const std::string& name) {
    if (in_graph.contains(name)) return true;
    errors.push_back(at(scene, c) + "found joint " + name +
                     " between bodies that stand still; expected a joint that moves");
    return false;
  }

  // Whether a joint of a gear is on what the carrier turns on; else it is on the carrier.
  bool on_base(const Constraint& c, const std::string& name) {
    const Edge& carrier = *edge_of.at(c.carrier);
    const Edge& joint = *edge_of.at(name);
    const auto touches = [&](int group) { return joint.group_a == group || joint.group_b == group; };
    if (touches(carrier.group_b)) return false;
    if (touches(carrier.group_a)) return true;
    errors.push_back(at(scene, c) + "found joint " + name + " neither on the carrier " +
                     scene.joints[in_graph.at(c.carrier)].child.body + " nor on " +
                     scene.joints[in_graph.at(c.carrier)].parent.body + ", which it turns on; expected one of them");
    return true;
  }

  // factor: of the user's coordinate.
  void add_term(CoordinateRow& row, const Constraint& c, const std::string& name, int component, double factor) {
    if (!moves(c, name)) return;
    const JointPlace& place = places.joints[in_graph.at(name)];
    if (place.role != JointPlace::Role::tree) {
      errors.push_back(at(scene, c) + "found joint " + name +
                       " in a loop in which every joint is constrained; expected a loop with at least one joint "
                       "without motion, gear or rack, where it can be cut");
      return;
    }
    row.terms.push_back({place.iq + component, place.iv + component, factor * place.q_sign[component]});
  }
};

}  // namespace

std::vector<std::string_view> constrained_joints(const Scene& scene) {
  std::vector<std::string_view> out;
  for (const Constraint& c : scene.constraints) {
    for (const std::string* name : {&c.joint, &c.other, &c.carrier}) {
      if (!name->empty()) out.emplace_back(*name);
    }
  }
  return out;
}

std::vector<ContactEdge> contacts_of(const Scene& scene, const std::vector<int>& group_of,
                                     const std::vector<Pose3>& X_GB) {
  const BodyNumbers number(scene);
  std::vector<ContactEdge> out;
  std::vector<std::string> errors;
  for (int i = 0; i < static_cast<int>(scene.constraints.size()); ++i) {
    const Constraint& c = scene.constraints[i];
    if (!is_contact(c)) continue;
    const int a = number(c.on.body) + 1;
    const int b = number(c.at.body) + 1;
    ContactEdge edge;
    edge.constraint = i;
    if (c.type == ConstraintType::rolling) {
      Rolling wheel;
      wheel.radius = c.radius;
      edge.joint = wheel;
    } else {
      edge.joint = KnifeEdge();
    }
    edge.group_a = group_of[a];
    edge.group_b = group_of[b];
    edge.X_AF = X_GB[a] * c.on.X_BF;
    edge.X_BM = X_GB[b] * c.at.X_BF * with_z_along(c.axis);
    if (edge.group_a == edge.group_b) {
      errors.push_back(at(scene, c) + "found " + c.at.body + " welded to " + c.on.body +
                       ", which it is on; expected bodies that can move against each other");
    }
    out.push_back(edge);
  }
  if (!errors.empty()) throw SceneError(errors);
  return out;
}

std::vector<CoordinateRow> coordinate_rows(const Scene& scene, const Graph& graph, int island, ReducedScene& places) {
  RowMaker maker{.scene = scene, .graph = graph, .island = island, .places = places};
  maker.run();
  return std::move(maker.out);
}

}  // namespace gelenk
