// SPDX-License-Identifier: BSD-3-Clause
// What a scene is reduced to: its islands, each the smallest model that gives the scene's answers, and where each
// body and joint of the scene has gone. Immutable; threads may share it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "element/cut_joint.h"
#include "element/motion_law.h"
#include "scene/scene.h"

namespace gelenk {

// A rigid link. Its frame L is its tree joint's outer frame.
struct Link {
  std::string name;  // of its heaviest body: for messages
  int parent = -1;   // link
  int scene_joint = -1;
  TreeJoint joint;
  bool reversed = false;  // the outer link is the scene joint's parent
  int iq = 0, iv = 0;     // where its coordinates and speeds begin
  int nq = 0, nv = 0;
  Pose3 X_PJ;          // the joint's inner frame in the parent link
  Spatial::Inertia G;  // about L in L
};

// Most coordinates and speeds that a cut has.
inline constexpr int max_cut_nq = Rod::max_nq;
inline constexpr int max_cut_nv = Rod::max_nv;

// A joint that closes a loop: rows between frame F on link a and frame M on link b.
struct Cut {
  std::vector<int> scene_joints;  // one; of a rod those at its two ends; of a contact none
  int constraint = -1;            // of the scene: of a contact
  CutJoint joint;
  int link_a = 0, link_b = 0;
  Pose3 X_AF, X_BM;
  std::vector<int> kept;  // those of the joint's rows that are needed, ascending
  int joint_rows = 0;     // all it has
  int first_row = 0, rows = 0;
  int iq = 0, iv = 0;  // in the list of all cut joints' coordinates and speeds
  int nq = 0, nv = 0;
  std::vector<bool> turns;          // by coordinate: an angle, which the pose tells within a turn
  std::vector<int> path_a, path_b;  // links from a (b) up to, without, their nearest common ancestor

  bool is_rod() const { return scene_joints.size() > 1; }
  bool is_contact() const { return constraint >= 0; }
};

// A row in coordinates of tree joints, sum factor q = s(t), or only in its rate.
struct CoordinateRow {
  struct Term {
    int q = 0, v = 0;   // the coordinate, and the speed that is its rate
    double factor = 1;  // in the mechanism's sign
  };
  int constraint = -1;  // of the scene
  std::vector<Term> terms;
  bool is_angle = false;         // of rad, not m
  bool holds_position = true;    // else the rates alone
  std::optional<MotionLaw> law;  // s; none: it is constant, or an input
  double constant = 0;
  int input = -1;  // of the scene: s, or, where positions are not held, its rate

  bool moves() const { return law || input >= 0; }
};

// Rigid links in depth-first order on a spanning tree, and the joints left over, which close loops. Link 0 is the
// ground; each other link hangs on one tree joint. In a planar mechanism all link frames have z along the plane's
// normal, the ground's included.
struct Mechanism {
  std::vector<Link> links;
  std::vector<Cut> cuts;
  std::vector<CoordinateRow> coordinate_rows;  // behind those of the cuts; those that stand still first
  std::vector<int> joints;                     // the scene's joints in it, in file order
  int nq = 0, nv = 0, rows = 0;
  int cut_nq = 0, cut_nv = 0;
  bool planar = false;
  // Some motion that the rows forbid has no inertia: the mass matrix alone is singular (mass_factor.h).
  bool mass_needs_rows = false;
  // The ground link's frame in the world: at the first joint on the ground, so that a mechanism far from the world's
  // origin is computed as exactly as one at it.
  Pose3 X_W0;
  std::vector<double> heights;  // planar: of each link's origin along the normal [m]

  int first_coordinate_row() const { return rows - static_cast<int>(coordinate_rows.size()); }
  // Some row changes with time, or by an input.
  bool driven() const { return !coordinate_rows.empty() && coordinate_rows.back().moves(); }
  // By row: it holds positions, not only their rates.
  std::vector<bool> position_rows() const;
};

// Where a body of the scene has gone.
struct BodyPlace {
  int island = -1;  // -1: it stands still
  int link = 0;
  Pose3 X_LB;    // in the link; of bodies that stand still: in the world; of rods: in the rod's frame
  int rod = -1;  // cut: the body is the rod there
};

// Where a constraint of the scene has gone.
struct ConstraintPlace {
  int island = -1;  // -1: nowhere, all it touches stands still
  int cut = -1;     // contacts
  int row = -1;     // of the coordinate rows; else
};

// Where a joint of the scene has gone.
struct JointPlace {
  enum class Role { tree, cut, rod, merged };  // rod: at an end of a rod that has become a cut
  Role role = Role::merged;
  int island = -1;
  int index = -1;                                      // link or cut
  int iq = 0, iv = 0;                                  // tree: in q, v; else: in the cut joints' lists
  std::vector<double> q_sign, v_sign;                  // user's value = sign * ours
  Eigen::Matrix3d R_UC = Eigen::Matrix3d::Identity();  // from the user's joint frame F to ours
  std::vector<double> q;                               // merged: what its coordinates stay at, the user's
};

// What a reduction did, for people.
struct Note {
  Reduction pass = Reduction::weld;
  std::string text;
  bool changed = true;  // false: why it did nothing
};

struct ReducedScene {
  std::vector<Mechanism> islands;
  std::vector<BodyPlace> bodies;             // by scene body
  std::vector<JointPlace> joints;            // by scene joint
  std::vector<ConstraintPlace> constraints;  // by scene constraint
  std::vector<Note> notes;
};

// Joints known to stand still, and where: the user's coordinates by scene joint, empty for those that move.
using ImmobileJoints = std::vector<std::vector<double>>;

// Applies the reductions that need no more than the scene itself; scene.solver says which are on.
// Throws SceneError for welds that contradict each other and for drives that cannot be modelled.
ReducedScene reduce(const Scene& scene, const ImmobileJoints& immobile = {});

// The mechanism without the rows that are not listed. kept: by cut, as Cut::kept.
Mechanism with_rows(const Mechanism& mechanism, const std::vector<std::vector<int>>& kept);
// The mechanism without the rows that change with time.
Mechanism without_drives(const Mechanism& mechanism);

// Link of an island, and pose in it, of a frame on a body of the scene; what stands still is on its link 0.
BodyPlace place(const Scene& scene, const ReducedScene& reduced, int island, const BodyFrame& frame);

}  // namespace gelenk
