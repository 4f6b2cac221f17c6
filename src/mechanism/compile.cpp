// SPDX-License-Identifier: BSD-3-Clause
// From the graph to links in depth-first order, cuts, and the places of the scene's bodies and joints.
#include <algorithm>
#include <cmath>

#include "mechanism/graph.h"

namespace gelenk {
namespace {

// Heights of two halves of a cut joint must agree for planar algebra, which does not see them.
constexpr double height_gap = 1e-9;

struct Compiler {
  const Scene& scene;
  Graph graph;
  std::vector<bool> against{};  // by edge: the axis points against the plane's normal
  Mechanism out{};
  std::vector<int> link_of{};  // by group
  std::vector<Pose3> X_LG{};   // by group: its frame in its link's

  void run(bool planar) {
    out.planar = planar;
    link_of.assign(graph.groups.size(), -1);
    X_LG.resize(graph.groups.size());
    out.joints.resize(scene.joints.size());
    const std::vector<int> tree = spanning_tree(scene, graph);
    add_ground();
    add_children(0, tree);
    for (int e = 0; e < static_cast<int>(graph.edges.size()); ++e) {
      if (std::ranges::find(tree, e) == tree.end()) add_cut(e);
    }
    place_bodies();
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

  void add_children(int group, const std::vector<int>& tree) {
    for (const int e : tree) {
      const Edge& edge = graph.edges[e];
      if (edge.group_a != group && edge.group_b != group) continue;
      const int other = edge.group_a == group ? edge.group_b : edge.group_a;
      if (link_of[other] >= 0) continue;
      add_link(e, group, other);
      add_children(other, tree);
    }
  }

  // Frames of a joint that the tree meets from M's side and that reverses by turning (registry.h):
  // half a turn about x, or, planar, about z for sliding joints; planar hinges change sign instead.
  Eigen::Matrix3d reversal(const Edge& edge) const {
    const bool hinge = kind_of(edge.joint).planar == PlanarRole::normal;
    if (!reverses_by_turning(edge.joint) || (out.planar && hinge)) return Eigen::Matrix3d::Identity();
    const Eigen::Vector3d about_x(1, -1, -1);
    const Eigen::Vector3d about_z(-1, -1, 1);
    return (out.planar ? about_z : about_x).asDiagonal();
  }

  void add_link(int e, int inner, int outer) {
    const Edge& edge = graph.edges[e];
    const JointKind& kind = kind_of(edge.joint);
    const bool reversed = edge.group_b == inner;
    const Pose3 turn{reversed ? reversal(edge) : Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()};
    const Pose3 X_GL = (reversed ? edge.X_AF : edge.X_BM) * turn;
    Link link;
    link.name = name_of(outer);
    link.parent = link_of[inner];
    link.scene_joint = edge.scene_joint;
    link.joint = tree_joint(edge.joint, reversed);
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
    place_joint(e, JointPlace::Role::tree, link_of[outer], link.iq, link.iv, reversed);
    out.links.push_back(link);
  }

  void add_cut(int e) {
    const Edge& edge = graph.edges[e];
    const JointKind& kind = kind_of(edge.joint);
    Cut cut;
    cut.scene_joint = edge.scene_joint;
    cut.joint = edge.joint;
    cut.link_a = link_of[edge.group_a];
    cut.link_b = link_of[edge.group_b];
    cut.X_AF = X_LG[edge.group_a] * edge.X_AF;
    cut.X_BM = X_LG[edge.group_b] * edge.X_BM;
    cut.rows = (out.planar ? 3 : 6) - kind.nv;
    cut.first_row = out.rows;
    cut.iq = out.cut_nq;
    cut.iv = out.cut_nv;
    out.rows += cut.rows;
    out.cut_nq += kind.nq;
    out.cut_nv += kind.nv;
    find_paths(cut);
    place_joint(e, JointPlace::Role::cut, static_cast<int>(out.cuts.size()), cut.iq, cut.iv, false);
    out.cuts.push_back(cut);
  }

  // Links are numbered depth first, so the larger of two numbers is never the other's ancestor.
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

  void place_joint(int e, JointPlace::Role role, int index, int iq, int iv, bool reversed) {
    const Edge& edge = graph.edges[e];
    const JointKind& kind = kind_of(edge.joint);
    JointPlace& place = out.joints[edge.scene_joint];
    place.role = role;
    place.index = index;
    place.iq = iq;
    place.iv = iv;
    place.R_UC = edge.R_UC;
    place.q_sign.assign(kind.nq, 1);
    place.v_sign.assign(kind.nv, 1);
    if (!out.planar) return;
    const auto flip = flip_signs(edge.joint);
    const bool hinge = kind.planar == PlanarRole::normal && reverses_by_turning(edge.joint);
    for (int i = 0; i < kind.nq; ++i) {
      if (against[e]) place.q_sign[i] *= flip[i];
      if (reversed && hinge) place.q_sign[i] *= flip[i];
    }
    place.v_sign = place.q_sign;  // planar joints have nq = nv
  }

  void place_bodies() {
    out.bodies.resize(scene.bodies.size());
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const int group = graph.group_of[i];
      out.bodies[i] = {link_of[group], X_LG[group] * graph.X_GB[i]};
    }
  }

  std::string name_of(int group) const {
    const auto& bodies = graph.groups[group].bodies;
    const auto heaviest =
        std::ranges::max_element(bodies, [&](int a, int b) { return scene.bodies[a].mass < scene.bodies[b].mass; });
    return scene.bodies[*heaviest].name;
  }
};

bool heights_agree(const Mechanism& mechanism) {
  return std::ranges::all_of(mechanism.cuts, [&](const Cut& cut) {
    const double a = mechanism.heights[cut.link_a] + cut.X_AF.p.z();
    const double b = mechanism.heights[cut.link_b] + cut.X_BM.p.z();
    return std::abs(a - b) <= height_gap;
  });
}

void check_drives(const Scene& scene, const Mechanism& mechanism) {
  std::vector<std::string> errors;
  for (const Motor& motor : scene.motors) {
    const auto joint = std::ranges::find(scene.joints, motor.joint, &Joint::name);
    const JointPlace& place = mechanism.joints[joint - scene.joints.begin()];
    if (place.role == JointPlace::Role::tree || motor.rotor_inertia == 0) continue;
    errors.push_back((scene.file.empty() ? "" : scene.file + ": ") + "motors." + motor.name + ".rotor_inertia: found " +
                     std::to_string(motor.rotor_inertia) +
                     " kg m2 where every joint of a loop is driven with rotor inertia; expected 0 at one joint of "
                     "each loop (add the rotor's inertia to a body there)");
  }
  if (!errors.empty()) throw SceneError(errors);
}

}  // namespace

Mechanism compile(const Scene& scene, const CompileOptions& options) {
  std::vector<bool> keep(scene.joints.size(), false);
  for (const Sensor& sensor : scene.sensors) {
    if (sensor.type != SensorType::reaction) continue;
    const auto joint = std::ranges::find(scene.joints, sensor.joint, &Joint::name);
    keep[joint - scene.joints.begin()] = true;
  }
  // Planar algebra does not know forces along the normal: reactions need space.
  const bool reactions = std::ranges::find(keep, true) != keep.end();
  Compiler compiler{.scene = scene, .graph = merge_welds(scene, keep)};
  if (options.planar && !reactions) {
    if (const auto normals = plane_normals(compiler.graph)) {
      Compiler planar = compiler;
      planar.against = align_to_plane(planar.graph, *normals);
      planar.out.X_W0.R = rotation_taking_z_to((*normals)[0]);
      planar.run(true);
      if (heights_agree(planar.out)) {
        check_drives(scene, planar.out);
        return planar.out;
      }
    }
  }
  compiler.run(false);
  check_drives(scene, compiler.out);
  return compiler.out;
}

BodyPlace place(const Scene& scene, const Mechanism& mechanism, const BodyFrame& frame) {
  const int body = body_index(scene, frame.body);
  if (body < 0) return {0, mechanism.X_W0.inverse() * frame.X_BF};
  const BodyPlace& found = mechanism.bodies[body];
  return {found.link, found.X_LB * frame.X_BF};
}

}  // namespace gelenk
