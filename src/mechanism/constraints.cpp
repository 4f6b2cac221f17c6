// SPDX-License-Identifier: BSD-3-Clause
// Reduction of the scene's constraints to contacts between groups and constraint equations in joint coordinates.
#include <algorithm>
#include <memory>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "element/constraints/cut_joint.h"
#include "element/constraints/mesh_losses.h"
#include "element/kinds.h"
#include "mechanism/graph.h"
#include "scene/element_numbers.h"
#include "scene/formulas.h"
#include "scene/signals.h"

namespace gelenk {
namespace {

// Location for error messages: "scene.yaml: constraints.mesh: ".
std::string location(const Scene& scene, const Constraint& c) {
  return (scene.file.empty() ? "" : scene.file + ": ") + "constraints." + c.name + ": ";
}

// A rotation whose z axis is along the unit vector `axis`.
Pose3 with_z_along(const Eigen::Vector3d& axis) { return {rotation_taking_z_to(axis), Eigen::Vector3d::Zero()}; }

struct CoordinateRowBuilder {
  const Scene& scene;
  const Graph& graph;
  int island;
  ReducedScene& places;
  std::unordered_map<std::string_view, int> joint_index{};      // scene joint by name
  std::unordered_map<std::string_view, const Edge*> edge_of{};  // by joint
  std::vector<CoordinateRow> out{};
  std::vector<std::string> errors{};

  void run() {
    for (const Edge& edge : graph.edges) {
      const std::string& name = scene.joints[edge.scene_joint].name;
      joint_index.emplace(name, edge.scene_joint);
      edge_of.emplace(name, &edge);
    }
    const std::vector<int> inputs = first_inputs(scene)[sections::constraints];
    for (int c = 0; c < static_cast<int>(scene.constraints.size()); ++c) {
      const Constraint& constraint = scene.constraints[c];
      if (kind_of(*constraint.is).is_between_bodies || !joint_index.contains(constraint.joints.front())) continue;
      CoordinateRow& row = out.emplace_back();
      row.constraint = c;
      std::visit([&](const auto& element) { fill(row, constraint, element, inputs[c]); }, *constraint.is);
    }
    if (!errors.empty()) throw SceneError(errors);
    std::ranges::sort(out, {}, [](const CoordinateRow& row) { return std::pair(row.moves(), row.constraint); });
    for (std::size_t r = 0; r < out.size(); ++r)
      places.constraints[out[r].constraint] = {island, -1, static_cast<int>(r)};
  }

  template <class C>
  void fill(CoordinateRow& row, const Constraint& c, const C& element, int input) {
    const JointKind& kind = kind_of(*scene.joints[joint_index.at(c.joints.front())].is);
    const int component = component_of(kind, c.coordinate);
    row.is_angle = kind.q[component].unit == "rad";
    if constexpr (LosesPower<C>) {
      if (element.losses().are_any()) row.lossy_term = C::lossy_joint;
    }
    if constexpr (requires { element.factor(0, [](int) { return true; }); }) add_terms(row, c, element, component);
    if constexpr (Relates<C>) relate(row, c, element, component);
    if constexpr (requires { element.constant(); }) row.constant = element.constant();
    if constexpr (requires { element.law(); }) row.law = element.law();
    if constexpr (requires { element.holds_position(); }) row.holds_position = element.holds_position();
    if constexpr (requires { element.follows_signals(); }) row.follows_signals = element.follows_signals();
    if constexpr (requires { element.follows_input(); }) {
      if (element.follows_input()) row.input = input;
      row.derivative_inputs = element.derivative_inputs();
    }
  }

  // The last joint (the carrier) is used only if all others move.
  template <class C>
  void add_terms(CoordinateRow& row, const Constraint& c, const C& element, int component) {
    const auto base = [&](int k) { return on_base(c, c.joints[static_cast<std::size_t>(k)]); };
    bool all = true;
    for (std::size_t i = 0; i < c.joints.size(); ++i) {
      const std::string& name = c.joints[i];
      if (name.empty() || !all) continue;
      all = check_moves(c, name);
      if (!all) continue;
      const double factor = element.factor(static_cast<int>(i), base);
      if (i == 2 && row.has_losses() && base(0)) {
        errors.push_back(location(scene, c) + "found efficiency with joint " + c.joints.front() +
                         " on the base of the " + "carrier " + name +
                         "; expected `joint` on the carrier, or none: losses are friction of `joint`");
      }
      if (factor != 0) add_term(row, c, name, i == 0 ? component : 0, factor);
    }
  }

  // The coordinate whose force is shown comes first.
  void relate(CoordinateRow& row, const Constraint& c, const Relation& element, int component) {
    struct Coordinate {
      int joint, component;
      bool operator==(const Coordinate&) const = default;
    };
    const Formula& formula = element.relation();
    const Coordinate own{joint_index.at(c.joints.front()), component};
    std::vector<Coordinate> related = {own};
    std::vector<RelationLaw::Named> named;
    const std::string where = location(scene, c);
    for (const std::string& name : formula.signal_names()) {
      const std::optional<JointQuantity> of = find_coordinate(scene, name);
      const Joint* const joint = of ? &scene.joints[static_cast<std::size_t>(of->joint)] : nullptr;
      if (!of || (!of->is_rate && kind_of(*joint->is).nq != kind_of(*joint->is).nv)) {
        errors.push_back(where + "found " + name + " in the relation, expected coordinates or rates of joints");
        return;
      }
      if (!check_moves(c, joint->name)) return;
      const Coordinate coordinate{of->joint, of->component};
      const auto known = std::ranges::find(related, coordinate);
      named.push_back({.term = static_cast<int>(known - related.begin()),
                       .is_rate = of->is_rate,
                       .size = scene.units.size_of(of->unit)});
      if (known == related.end()) related.push_back(coordinate);
    }
    const bool names_own = std::ranges::find(named, 0, &RelationLaw::Named::term) != named.end();
    const bool names_rates = std::ranges::any_of(named, &RelationLaw::Named::is_rate);
    if (element.gives_coordinate() && names_rates) {
      errors.push_back(where + "found a rate in gives, expected coordinates; a relation of rates is `zero`");
      return;
    }
    if (!element.gives_coordinate() && !names_own) {
      errors.push_back(where + "found no coordinate of joint " + c.joints.front() +
                       " in zero, expected the joint whose force is the output to be one that the relation names");
      return;
    }
    const std::string_view unit =
        kind_of(*scene.joints[static_cast<std::size_t>(own.joint)].is).q[static_cast<std::size_t>(component)].unit;
    if (element.gives_coordinate()) named.push_back({.term = 0, .is_rate = false, .size = scene.units.size_of(unit)});
    for (const Coordinate& of : related)
      add_term(row, c, scene.joints[static_cast<std::size_t>(of.joint)].name, of.component, 1);
    row.relation = std::make_shared<RelationLaw>(formula, std::move(named), static_cast<int>(related.size()),
                                                 element.gives_coordinate());
    row.holds_position = !row.relation->is_of_rates();
    if (!row.relation->is_linear())
      errors.push_back(where + "found a relation that is not linear in the rates, expected one that is");
  }

  // Whether the joint can move; otherwise reports an error. Joints between immobile bodies are not in the graph.
  bool check_moves(const Constraint& c, const std::string& name) {
    if (joint_index.contains(name)) return true;
    errors.push_back(location(scene, c) + "found joint " + name +
                     " between immobile bodies; expected a joint that can move");
    return false;
  }

  // Whether a joint is on the base of the carrier joint (the last one); otherwise it is on the carrier itself.
  bool on_base(const Constraint& c, const std::string& name) {
    const Edge& carrier = *edge_of.at(c.joints.back());
    const Edge& joint = *edge_of.at(name);
    const auto touches = [&](int group) { return joint.group_a == group || joint.group_b == group; };
    if (touches(carrier.group_b)) return false;
    if (touches(carrier.group_a)) return true;
    errors.push_back(location(scene, c) + "found joint " + name + " neither on the carrier " +
                     scene.joints[joint_index.at(c.joints.back())].child.body + " nor on " +
                     scene.joints[joint_index.at(c.joints.back())].parent.body +
                     ", the two bodies of the carrier joint; expected a joint of one of them");
    return true;
  }

  // Adds factor * q, with the user's coordinate q.
  void add_term(CoordinateRow& row, const Constraint& c, const std::string& name, int component, double factor) {
    const JointPlace& place = places.joints[joint_index.at(name)];
    if (place.role != JointPlace::Role::tree) {
      errors.push_back(location(scene, c) + "found joint " + name +
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
    for (const std::string& name : c.joints) {
      if (!name.empty()) out.emplace_back(name);
    }
    std::visit(
        [&]<class C>(const C& element) {
          if constexpr (Relates<C>) {
            for (const std::string_view name : element.relation().signal_names())
              out.push_back(name.substr(0, name.find('.')));
          }
        },
        *c.is);
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
    if (!kind_of(*c.is).is_between_bodies) continue;
    const BodyFrame& of = c.frames[0];
    const BodyFrame& on = c.frames[1];
    const int a = number(on.body) + 1;
    const int b = number(of.body) + 1;
    ContactEdge edge;
    edge.constraint = i;
    Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
    std::visit(
        [&](const auto& element) {
          if constexpr (BodyConstraint<std::decay_t<decltype(element)>>) {
            AnyBodyConstraint& of = edge.joint->emplace<AnyBodyConstraint>();
            if constexpr (requires { element.prepared(); }) {
              of.is = element.prepared();
            } else {
              of.is = element;
            }
            if constexpr (requires { element.axis; }) axis = element.axis.along;
          }
        },
        *c.is);
    edge.group_a = group_of[a];
    edge.group_b = group_of[b];
    edge.X_AF = X_GB[a] * on.X_BF;
    edge.X_BM = X_GB[b] * of.X_BF * with_z_along(axis);
    if (edge.group_a == edge.group_b) {
      errors.push_back(location(scene, c) + "found " + of.body + " welded to " + on.body +
                       "; expected two bodies that can move relative to each other");
    }
    out.push_back(edge);
  }
  if (!errors.empty()) throw SceneError(errors);
  return out;
}

std::vector<CoordinateRow> coordinate_rows(const Scene& scene, const Graph& graph, int island, ReducedScene& places) {
  CoordinateRowBuilder builder{.scene = scene, .graph = graph, .island = island, .places = places};
  builder.run();
  return std::move(builder.out);
}

}  // namespace gelenk
