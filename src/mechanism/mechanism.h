// SPDX-License-Identifier: BSD-3-Clause
// The result of the reductions: the islands of a scene, each the smallest model that gives the results of the scene,
// and the position of each body, joint and constraint of the scene in them. Immutable; threads may share it.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "element/constraints/motion_law.h"
#include "element/constraints/relation_law.h"
#include "element/kinds.h"
#include "joint/kinds.h"
#include "scene/reduction.h"
#include "shape/kinds.h"
#include "util/stored.h"

namespace gelenk {

struct Scene;

// A rigid link. Its frame L is the outer frame of its tree joint.
struct Link {
  std::string name;  // that of its heaviest body, for messages
  int parent = -1;   // link
  int scene_joint = -1;
  Stored<TreeJoint> joint;
  bool reversed = false;  // the outer link is the parent of the scene's joint
  int iq = 0, iv = 0;     // indices of its first coordinate and velocity
  int nq = 0, nv = 0;
  Pose3 X_PJ;          // pose of the joint's inner frame in the parent link
  Spatial::Inertia G;  // about and in L
};

// Maximum number of coordinates and velocities of a cut.
inline constexpr int max_cut_nq = 8;
inline constexpr int max_cut_nv = 6;

// A loop-closing joint: constraint equations between frame F on link a and frame M on link b.
struct Cut {
  std::vector<int> scene_joints;  // one; for a rod those at its two ends; for a contact none
  bool opens_beside = false;      // not that joint but the weld of a body that is split beside it
  int constraint = -1;            // contacts: index in the scene
  Stored<CutJoint> joint;
  int link_a = 0, link_b = 0;
  Pose3 X_AF, X_BM;
  std::vector<int> kept;  // the joint's equations that are not redundant, ascending
  int joint_rows = 0;     // number of the joint's equations
  int first_row = 0, rows = 0;
  int iq = 0, iv = 0;  // in the coordinates and velocities of all cut joints
  int nq = 0, nv = 0;
  std::vector<bool> is_angle;       // by coordinate: determined by the pose up to full revolutions
  std::vector<int> path_a, path_b;  // links from a (b) to their nearest common ancestor, exclusive

  bool is_rod() const { return scene_joints.size() > 1; }
  bool is_contact() const { return constraint >= 0; }
};

// A constraint equation in coordinates of tree joints, sum factor q = s(t), or only its rate; or a relation.
struct CoordinateRow {
  struct Term {
    int q = 0, v = 0;   // indices of the coordinate and of its rate
    double factor = 1;  // in the mechanism's sign convention
  };
  int constraint = -1;  // of the scene
  std::vector<Term> terms;
  bool is_angle = false;         // in rad, not m
  bool holds_position = true;    // otherwise nonholonomic: only the rates
  std::optional<MotionLaw> law;  // s; none: s is constant or an input
  double constant = 0;
  int input = -1;                // index in the scene: s, or its rate if positions are not held
  int derivative_inputs = 0;     // inputs after it that are its time derivatives
  bool follows_signals = false;  // s is an expression of signals (kinematics/loads.h)
  // Of the coordinates factor q and their rates, in place of the sum; the first one is that which shows the force.
  std::shared_ptr<const RelationLaw> relation;
  int lossy_term = -1;  // along whose coordinate the losses of a mesh are friction; -1: it has none

  bool has_losses() const { return lossy_term >= 0; }
  // Calls f(input, order) for each input; order: of the derivative of s that it prescribes.
  template <class F>
  void for_inputs(F f) const {
    for (int k = 0; input >= 0 && k <= derivative_inputs; ++k) f(input + k, (holds_position ? 0 : 1) + k);
  }
  // Whether the constraint is rheonomic.
  bool moves() const { return law || input >= 0 || follows_signals; }
};

// A shape fixed in a link.
struct LinkShape {
  int link = 0;
  Pose3 X_LS;
  Stored<AnyShape> is;
  int surface = 0;      // number of its surface in ContactTable
  int scene_body = -1;  // -1: the ground
};

// Which shapes can touch.
struct ContactTable {
  std::vector<std::string> surfaces;
  std::vector<int> contacts;                // surfaces x surfaces: the contact of the scene, -1: none
  std::vector<std::pair<int, int>> joined;  // bodies that share a joint, the smaller first; ascending
  std::vector<bool> touches_joined;         // by contact of the scene: also between such bodies

  std::vector<int> first_surfaces;  // by contact of the scene

  bool is_first(int contact, int surface) const { return first_surfaces[static_cast<std::size_t>(contact)] == surface; }
  int contact(int surface_a, int surface_b) const {
    return contacts[static_cast<std::size_t>(surface_a) * surfaces.size() + static_cast<std::size_t>(surface_b)];
  }
};

// The limit of the swing of a ball joint: the angle between an axis of one link and one of another.
struct Swing {
  int contact = 0;  // its number after those of the contacts of the scene (scene/touching_laws.h)
  int link_a = 0, link_b = 0;
  Eigen::Vector3d axis_a = Eigen::Vector3d::UnitZ(), axis_b = Eigen::Vector3d::UnitZ();  // unit, in their links
  double angle = 0;                                                                      // rad
  int body_a = -1, body_b = -1;                                                          // of the scene; -1: the ground
  Eigen::Vector3d p_b = Eigen::Vector3d::Zero();                                         // m: the joint, in link b
};

// Dry friction of a joint along several velocities together: of the rotation of one link relative to another, or of the
// motion of a point, in a plane or in space.
struct LinkFriction {
  int contact = 0;  // its number after those of the contacts of the scene (scene/touching_laws.h)
  int link_a = 0, link_b = 0;
  bool turns = false;
  int dimension = 3;                                                                     // 2: in the x-y plane of F
  Eigen::Matrix3d R_a = Eigen::Matrix3d::Identity(), R_b = Eigen::Matrix3d::Identity();  // of F and M in their links
  int body_a = -1, body_b = -1;                                                          // of the scene; -1: the ground
  Eigen::Vector3d p_b = Eigen::Vector3d::Zero();                                         // m: the joint, in link b
};

// Rigid links in depth-first order on a spanning tree, and the remaining joints, which close loops. Link 0 is the
// ground; each other link has one tree joint. In a planar mechanism the z axes of all link frames, including that of
// the ground, are along the normal of the plane.
struct Mechanism {
  std::vector<Link> links;
  std::vector<Cut> cuts;
  std::vector<CoordinateRow> coordinate_rows;  // after those of the cuts; scleronomic ones first
  std::vector<int> joints;                     // its joints of the scene, in file order
  std::vector<int> states;                     // its element states of the scene, in file order
  std::vector<int> expressions;                // its named expressions of the scene, in file order
  std::vector<std::string> state_names;        // of the element states
  int nq = 0, nv = 0, rows = 0;
  int cut_nq = 0, cut_nv = 0;
  bool planar = false;
  // A motion that the constraints exclude has no inertia: the mass matrix alone is singular (mass_factor.h).
  bool mass_needs_rows = false;
  // Pose of the ground link's frame in the world: at the first joint on the ground, so that a mechanism far from the
  // origin of the world loses no digits.
  Pose3 X_W0;
  std::vector<double> heights;    // planar: position of each link's origin along the normal [m]
  std::vector<LinkShape> shapes;  // those that can touch others; bodies of the scene in their order, the ground last
  ContactTable contact_table;     // if there are shapes
  std::vector<Swing> swings;      // limits of ball joints
  std::vector<LinkFriction> frictions;

  // Whether it has laws of contacts: of shapes, of axes that touch the cones of their limits, of friction.
  bool touches() const { return !shapes.empty() || !swings.empty() || !frictions.empty(); }

  int first_coordinate_row() const { return rows - static_cast<int>(coordinate_rows.size()); }
  // Whether any constraint equation depends on time or on an input.
  bool driven() const { return !coordinate_rows.empty() && coordinate_rows.back().moves(); }
  // By constraint equation: whether it constrains positions, not only rates.
  std::vector<bool> position_rows() const;
};

// The position of a body of the scene in the reduced scene.
struct BodyPlace {
  int island = -1;  // -1: immobile
  int link = 0;
  Pose3 X_LB;    // in the link; immobile bodies: in the world; rods: in the rod's frame
  int rod = -1;  // index of the cut if the body is a massless rod
};

// The position of a constraint of the scene in the reduced scene.
struct ConstraintPlace {
  int island = -1;  // -1: all its bodies are immobile
  int cut = -1;     // for contacts
  int row = -1;     // otherwise: in coordinate_rows
};

// The position of a joint of the scene in the reduced scene.
struct JointPlace {
  enum class Role { tree, cut, rod, merged };  // rod: at an end of a massless rod
  Role role = Role::merged;
  int island = -1;
  int index = -1;                                      // link or cut
  int iq = 0, iv = 0;                                  // tree: in q, v; otherwise: in those of cut joints
  std::vector<double> q_sign, v_sign;                  // user's value = sign * mechanism's value
  Eigen::Matrix3d R_UC = Eigen::Matrix3d::Identity();  // from the user's joint frame F to the mechanism's
  std::vector<double> q;                               // merged: its constant coordinates, the user's
};

// A description of the effect of a reduction, for reports.
struct Note {
  Reduction pass = Reduction::weld;
  std::string text;
  bool changed = true;  // false: the text is the reason why it has no effect
};

struct ReducedScene {
  std::vector<Mechanism> islands;
  std::vector<BodyPlace> bodies;             // by scene body
  std::vector<JointPlace> joints;            // by scene joint
  std::vector<ConstraintPlace> constraints;  // by scene constraint
  std::vector<Note> notes;
};

// The coordinates (user's) of immobile joints, by scene joint; empty for joints that move.
using ImmobileJoints = std::vector<std::vector<double>>;

// Applies the reductions that require only the scene, as enabled in scene.solver. Throws SceneError for welds that
// contradict each other, and for motors and constraints that cannot be modeled.
ReducedScene reduce(const Scene& scene, const ImmobileJoints& immobile = {});

// The mechanism with only the listed constraint equations of its cuts. kept: by cut, as Cut::kept.
Mechanism with_rows(const Mechanism& mechanism, const std::vector<std::vector<int>>& kept);
// The mechanism without its rheonomic constraint equations.
Mechanism without_drives(const Mechanism& mechanism);

// The link of an island, and the pose in it, of a frame on a body of the scene. Immobile frames are on link 0.
BodyPlace place(const Scene& scene, const ReducedScene& reduced, int island, const BodyFrame& frame);

}  // namespace gelenk
