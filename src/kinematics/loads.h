// SPDX-License-Identifier: BSD-3-Clause
// All loads on an island.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "element/constraints/mesh_losses.h"
#include "element/kinds.h"
#include "kinematics/forces.h"
#include "kinematics/joint_loads.h"
#include "kinematics/named_reading.h"
#include "mechanism/mechanism.h"

namespace gelenk {

// What an expression names of the motion: a coordinate of a joint, its rate, or an output of a sensor.
struct NamedQuantity {
  int cut = -1;      // -1: of the tree
  int q = 0, v = 0;  // its indices in the tree or in the cut joint
  double sign = 1;   // user's value = sign * mechanism's value
  bool is_rate = false;
  bool moves = true;
  double value = 0;                             // if its joint is immobile
  std::shared_ptr<const NamedReading> reading;  // of a sensor; the above is then of no meaning
};

// A jump of an element state of an island, see scene/scene.h.
struct PlacedReset {
  int state = 0;  // among those of the island
  Formula when, to;
};

struct Loads {
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();   // m/s2, in the root's axes
  Eigen::Matrix3d R_0W = Eigen::Matrix3d::Identity();  // the world's axes, in the root's
  Eigen::Vector3d p_W0 = Eigen::Vector3d::Zero();      // m, position of the root in the world
  Stored<PlacedForces> forces;
  JointLoads tree;
  std::vector<JointLoads> cuts;       // by cut
  std::vector<double> added_inertia;  // kg m2 (kg), by velocity: of motors
  std::vector<ContactLaw> contacts;   // as scene/touching_laws.h
  std::vector<int> inputs;            // indices of the signals that act on this island
  // All signals: the inputs of the scene and its clock, the element states of the island, and what its expressions name
  // of the motion, which the kernels add.
  int first_state = 0;
  std::vector<Formula> rates;        // of the element states
  std::vector<PlacedReset> resets;   // of the element states
  std::vector<Formula> values;       // of the named expressions, as outputs
  std::vector<NamedQuantity> named;  // after those
  std::vector<MeshLosses> losses;    // by coordinate row
  // By coordinate row: s, s', s'' of one that follows signals; otherwise not given.
  std::vector<std::array<Formula, 3>> motions;
  // The derivative of this order of such a motion; 0 where it is not given. all: all signals.
  template <class T>
  T motion(std::size_t row, std::size_t order, const T* all) const {
    const Formula& of = motions[row][order];
    return of.is_given() ? of.value_among<T>(nullptr, all) : T(0);
  }
  std::shared_ptr<HeldBranches> branches;  // of its expressions
  bool only_along_tree = false;            // no force acts on links or along cuts
  // J: the part of gravity's potential energy that the kernels omit, between the origins of the world and the root
  // and, in planar mechanisms, along the normal.
  double potential_offset = 0;

  // Whether steps with impulses cannot be made.
  bool need_events() const { return !resets.empty() || rates_read_forces() || motions_follow_signals(); }
  bool motions_follow_signals() const {
    return std::ranges::any_of(motions, [](const auto& of) { return of[2].is_given(); });
  }
  bool rates_read_forces() const {
    return std::ranges::any_of(rates, [](const Formula& rate) { return rate.reads_forces(); });
  }
  int states() const { return static_cast<int>(rates.size()); }
  int first_named() const { return first_state + states(); }
  int signals() const { return first_named() + static_cast<int>(named.size()); }
};

// Links whose poses in the root frame are required by the loads, and their ancestors.
std::vector<int> links_with_loads(const Mechanism& mechanism, const Loads& loads);
// All but the ground.
std::vector<int> all_links(const Mechanism& mechanism);

}  // namespace gelenk
