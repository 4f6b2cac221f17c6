// SPDX-License-Identifier: BSD-3-Clause
// Mechanism: the smallest model that gives a scene's answers: rigid links in depth-first order on a
// spanning tree, and the joints left over, which close loops. Immutable; threads may share it.
//
// Link 0 is the ground. Each other link hangs on one tree joint; its frame L is that joint's outer frame.
// In a planar mechanism all link frames have z along the plane's normal, the ground's included.
#pragma once

#include <string>
#include <vector>

#include "joint/registry.h"
#include "scene/scene.h"

namespace gelenk {

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

// A joint that closes a loop: rows between frame F on link a and frame M on link b.
struct Cut {
  int scene_joint = -1;
  AnyJoint joint;
  int link_a = 0, link_b = 0;
  Pose3 X_AF, X_BM;
  int first_row = 0, rows = 0;
  int iq = 0, iv = 0;               // in the list of all cut joints' coordinates and speeds
  std::vector<int> path_a, path_b;  // links from a (b) up to, without, their nearest common ancestor
};

// Where a body of the scene has gone.
struct BodyPlace {
  int link = 0;
  Pose3 X_LB;
};

// Where a joint of the scene has gone.
struct JointPlace {
  enum class Role { tree, cut, merged };
  Role role = Role::merged;
  int index = -1;                                      // link or cut
  int iq = 0, iv = 0;                                  // tree: in q, v; cut: in the cut joints' lists
  std::vector<double> q_sign, v_sign;                  // user's value = sign * ours
  Eigen::Matrix3d R_UC = Eigen::Matrix3d::Identity();  // from the user's joint frame F to ours
};

struct Mechanism {
  std::vector<Link> links;
  std::vector<Cut> cuts;
  std::vector<BodyPlace> bodies;   // by scene body
  std::vector<JointPlace> joints;  // by scene joint
  int nq = 0, nv = 0, rows = 0;
  int cut_nq = 0, cut_nv = 0;
  bool planar = false;
  // The ground link's frame in the world: at the first joint on the ground, so that a mechanism far from the world's
  // origin is computed as exactly as one at it.
  Pose3 X_W0;
  std::vector<double> heights;  // planar: of each link's origin along the normal [m]
};

struct CompileOptions {
  bool planar = true;  // use planar algebra where the motion allows
};

// Throws SceneError for welds that contradict each other and for drives that cannot be modelled.
Mechanism compile(const Scene& scene, const CompileOptions& options = {});

// Link and pose in it of a frame on a body of the scene (by name).
BodyPlace place(const Scene& scene, const Mechanism& mechanism, const BodyFrame& frame);

}  // namespace gelenk
