// SPDX-License-Identifier: BSD-3-Clause
// Construction of a mechanism from a graph: links in depth-first order, cuts, and the places of bodies and joints.
#include <algorithm>
#include <numeric>

#include "element/constraints/cut_joint.h"
#include "joint/turns.h"
#include "mechanism/graph.h"

namespace gelenk {
namespace {

struct MechanismBuilder {
  const Scene& scene;
  const Graph& graph;
  int island;
  ReducedScene& places;
  Mechanism out{};
  std::vector<int> link_of{};  // by group
  std::vector<Pose3> X_LG{};   // by group: pose of its frame in its link's

  void run() {
    link_of.assign(graph.groups.size(), -1);
    X_LG.resize(graph.groups.size());
    const std::vector<int> tree = spanning_tree(scene, graph, out.planar);
    add_ground();
    add_links(tree);
    std::vector<bool> in_tree(graph.edges.size(), false);
    for (const int e : tree) in_tree[e] = true;
    for (int e = 0; e < static_cast<int>(graph.edges.size()); ++e) {
      if (!in_tree[e]) add_joint_cut(graph.edges[e]);
      if (!graph.edges[e].opens_beside) out.joints.push_back(graph.edges[e].scene_joint);
    }
    place_bodies();
    for (const RodEdge& rod : graph.rods) add_rod(rod);
    for (const ContactEdge& contact : graph.contacts) add_contact(contact);
    out.coordinate_rows = coordinate_rows(scene, graph, island, places);
    out.rows += static_cast<int>(out.coordinate_rows.size());
    std::ranges::sort(out.joints);
    out.states = graph.states;
    out.expressions = graph.expressions;
    for (const int state : out.states) out.state_names.push_back(scene.states[static_cast<std::size_t>(state)].name);
  }

  void add_ground() {
    Link link;
    link.name = ground;
    link_of[0] = 0;
    for (const Edge& edge : graph.edges) {
      if (edge.group_a != 0 && edge.group_b != 0) continue;
      out.X_W0.p = edge.group_a == 0 ? edge.X_AF.p : edge.X_BM.p;
      break;
    }
    X_LG[0] = out.X_W0.inverse();
    out.links.push_back(link);
    out.heights.push_back(0);
  }

  // Adds the links depth first, siblings in the order of the tree.
  void add_links(const std::vector<int>& tree) {
    std::vector<std::vector<int>> tree_edges(graph.groups.size());  // by group, reversed for the stack
    for (auto e = tree.rbegin(); e != tree.rend(); ++e) {
      tree_edges[graph.edges[*e].group_a].push_back(*e);
      tree_edges[graph.edges[*e].group_b].push_back(*e);
    }
    std::vector<std::pair<int, int>> open;  // edge, inner group
    const auto open_group = [&](int group) {
      for (const int e : tree_edges[group]) open.emplace_back(e, group);
    };
    open_group(0);
    while (!open.empty()) {
      const auto [e, inner] = open.back();
      open.pop_back();
      const Edge& edge = graph.edges[e];
      const int outer = edge.group_a == inner ? edge.group_b : edge.group_a;
      if (link_of[outer] >= 0) continue;
      add_link(e, inner, outer);
      open_group(outer);
    }
  }

  // Rotation of the frames of a joint that the tree traverses from M to F and that is reversed by a half turn
  // (registry.h): about x or, in planar mechanisms, about z for prismatic joints; planar revolute joints change sign
  // instead.
  Eigen::Matrix3d reversal(const Edge& edge) const {
    const bool hinge = kind_of(*edge.joint).planar == PlanarRole::normal;
    if (!reverses_by_turning(*edge.joint) || (out.planar && hinge)) return Eigen::Matrix3d::Identity();
    const Eigen::Vector3d about_x(1, -1, -1);
    const Eigen::Vector3d about_z(-1, -1, 1);
    return (out.planar ? about_z : about_x).asDiagonal();
  }

  void add_link(int e, int inner, int outer) {
    const Edge& edge = graph.edges[e];
    const JointKind& kind = kind_of(*edge.joint);
    const bool reversed = edge.group_b == inner;
    const Pose3 turn{reversed ? reversal(edge) : Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()};
    const Pose3 X_GL = (reversed ? edge.X_AF : edge.X_BM) * turn;
    Link link;
    link.name = name_of(outer);
    link.parent = link_of[inner];
    link.scene_joint = edge.scene_joint;
    link.joint = tree_joint(*edge.joint, reversed);
    link.reversed = reversed;
    link.iq = out.nq;
    link.iv = out.nv;
    link.nq = kind.nq;
    link.nv = kind.nv;
    link.X_PJ = X_LG[inner] * (reversed ? edge.X_BM : edge.X_AF) * turn;
    X_LG[outer] = X_GL.inverse();
    link.G = graph.groups[outer].G.moved_by(X_LG[outer]);
    link_of[outer] = static_cast<int>(out.links.size());
    out.nq += kind.nq;
    out.nv += kind.nv;
    out.heights.push_back(out.heights[link.parent] + link.X_PJ.p.z());
    place_joint(edge, JointPlace::Role::tree, link_of[outer], link.iq, link.iv, reversed);
    out.links.push_back(link);
  }

  void add_joint_cut(const Edge& edge) {
    const Joint& joint = scene.joints[edge.scene_joint];
    if (!edge.opens_beside && must_not_be_cut(joint, out.planar)) {
      throw SceneError(
          {(scene.file.empty() ? "" : scene.file + ": ") + "joints." + joint.name + "." +
           std::string(joint.locking_element()) +
           ": found friction or limits in every joint at which the loop can be cut; expected a loop with a body "
           "with mass, or with at least one joint without friction, limit, motion, gear and rack"});
    }
    Cut cut;
    cut.joint = cut_joint(*edge.joint);
    cut.joint_rows = (out.planar ? 3 : 6) - kind_of(*edge.joint).nv;
    add_ends(edge.group_a, edge.X_AF, edge.group_b, edge.X_BM, cut);
    cut.opens_beside = edge.opens_beside;
    if (edge.opens_beside) {
      cut.scene_joints.push_back(edge.scene_joint);
    } else {
      add_coordinates(edge, JointPlace::Role::cut, cut);
    }
    out.cuts.push_back(cut);
  }

  void add_rod(const RodEdge& rod) {
    Cut cut;
    cut.joint = CutJoint(rod.joint);
    cut.joint_rows = 1;
    add_ends(rod.group_a, rod.X_AF, rod.group_b, rod.X_BM, cut);
    add_coordinates(rod.first, JointPlace::Role::rod, cut);
    add_coordinates(rod.second, JointPlace::Role::rod, cut);
    // The rod's frame is the frame of its first joint.
    const Pose3 X_RG = (rod.first.group_a == rod.group ? rod.first.X_AF : rod.first.X_BM).inverse();
    const Group& group = graph.groups[rod.group];
    for (std::size_t i = 0; i < group.bodies.size(); ++i) {
      places.bodies[group.bodies[i]] = {island, 0, X_RG * group.X_GB[i], static_cast<int>(out.cuts.size())};
    }
    out.joints.push_back(rod.first.scene_joint);
    out.joints.push_back(rod.second.scene_joint);
    out.cuts.push_back(cut);
  }

  void add_contact(const ContactEdge& contact) {
    Cut cut;
    cut.constraint = contact.constraint;
    cut.joint = contact.joint;
    cut.joint_rows = row_count(*contact.joint);
    add_ends(contact.group_a, contact.X_AF, contact.group_b, contact.X_BM, cut);
    places.constraints[contact.constraint] = {island, static_cast<int>(out.cuts.size()), -1};
    out.cuts.push_back(cut);
  }

  void add_ends(int group_a, const Pose3& X_AF, int group_b, const Pose3& X_BM, Cut& cut) {
    cut.link_a = link_of[group_a];
    cut.link_b = link_of[group_b];
    cut.X_AF = X_LG[group_a] * X_AF;
    cut.X_BM = X_LG[group_b] * X_BM;
    cut.rows = cut.joint_rows;
    cut.kept.resize(cut.rows);
    std::iota(cut.kept.begin(), cut.kept.end(), 0);
    cut.first_row = out.rows;
    cut.iq = out.cut_nq;
    cut.iv = out.cut_nv;
    out.rows += cut.rows;
    find_paths(cut);
  }

  void add_coordinates(const Edge& edge, JointPlace::Role role, Cut& cut) {
    const JointKind& kind = kind_of(*edge.joint);
    cut.scene_joints.push_back(edge.scene_joint);
    place_joint(edge, role, static_cast<int>(out.cuts.size()), out.cut_nq, out.cut_nv, false);
    for (int i = 0; i < kind.nq; ++i) cut.is_angle.push_back(repeats_each_turn(*edge.joint, i));
    cut.nq += kind.nq;
    cut.nv += kind.nv;
    out.cut_nq += kind.nq;
    out.cut_nv += kind.nv;
  }

  // Links are numbered depth first, so the link with the larger number is never an ancestor of the other.
  void find_paths(Cut& cut) const {
    int a = cut.link_a;
    int b = cut.link_b;
    while (a != b) {
      if (a > b) {
        cut.path_a.push_back(a);
        a = out.links[a].parent;
      } else {
        cut.path_b.push_back(b);
        b = out.links[b].parent;
      }
    }
  }

  void place_joint(const Edge& edge, JointPlace::Role role, int index, int iq, int iv, bool reversed) {
    const JointKind& kind = kind_of(*edge.joint);
    JointPlace& place = places.joints[edge.scene_joint];
    place.role = role;
    place.island = island;
    place.index = index;
    place.iq = iq;
    place.iv = iv;
    place.R_UC = edge.R_UC;
    place.q_sign.assign(kind.nq, 1);
    place.v_sign.assign(kind.nv, 1);
    if (!out.planar) return;
    const auto flip = flip_signs(*edge.joint);
    const bool hinge = kind.planar == PlanarRole::normal && reverses_by_turning(*edge.joint);
    for (int i = 0; i < kind.nq; ++i) {
      if (edge.opposes_normal) place.q_sign[i] *= flip[i];
      if (reversed && hinge) place.q_sign[i] *= flip[i];
    }
    place.v_sign = place.q_sign;  // planar joints have nq = nv
  }

  void place_bodies() {
    for (std::size_t g = 0; g < graph.groups.size(); ++g) {
      if (link_of[g] < 0) continue;  // replaced by a rod
      const Group& group = graph.groups[g];
      for (std::size_t i = 0; i < group.bodies.size(); ++i) {
        places.bodies[group.bodies[i]] = {island, link_of[g], X_LG[g] * group.X_GB[i]};
      }
    }
  }

  std::string name_of(int group) const {
    const int whole = graph.groups[group].half_of;
    if (whole >= 0) return name_of(whole);
    const auto& bodies = graph.groups[group].bodies;
    const auto heaviest =
        std::ranges::max_element(bodies, [&](int a, int b) { return scene.bodies[a].mass < scene.bodies[b].mass; });
    return scene.bodies[*heaviest].name;
  }
};

}  // namespace

Mechanism make_mechanism(const Scene& scene, const Graph& graph, int island,
                         const std::optional<Eigen::Vector3d>& normal, ReducedScene& places) {
  MechanismBuilder builder{.scene = scene, .graph = graph, .island = island, .places = places};
  builder.out.planar = normal.has_value();
  if (normal) builder.out.X_W0.R = rotation_taking_z_to(*normal);
  builder.run();
  return std::move(builder.out);
}

}  // namespace gelenk
