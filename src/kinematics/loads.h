// SPDX-License-Identifier: BSD-3-Clause
// All loads on an island.
#pragma once

#include <memory>
#include <vector>

#include "element/kinds.h"
#include "kinematics/forces.h"
#include "kinematics/joint_loads.h"
#include "mechanism/mechanism.h"

namespace gelenk {

struct Loads {
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();   // m/s2, in the root's axes
  Eigen::Matrix3d R_0W = Eigen::Matrix3d::Identity();  // the world's axes, in the root's
  Eigen::Vector3d p_W0 = Eigen::Vector3d::Zero();      // m, position of the root in the world
  Stored<PlacedForces> forces;
  JointLoads tree;
  std::vector<JointLoads> cuts;            // by cut
  std::vector<double> added_inertia;       // kg m2 (kg), by velocity: of motors
  std::vector<ContactLaw> contacts;        // by contact of the scene
  std::vector<int> inputs;                 // indices of the scene's inputs that act on this island, and of the clock
  std::shared_ptr<HeldBranches> branches;  // of its expressions
  bool only_along_tree = false;            // no force acts on links or along cuts
  // J: the part of gravity's potential energy that the kernels omit, between the origins of the world and the root
  // and, in planar mechanisms, along the normal.
  double potential_offset = 0;
};

// Links whose poses in the root frame are required by the loads, and their ancestors.
std::vector<int> links_with_loads(const Mechanism& mechanism, const Loads& loads);

}  // namespace gelenk
