// SPDX-License-Identifier: BSD-3-Clause
// What the elements of a scene exert on its bodies at one state, as the elements themselves say it. Nothing of it is
// computed in a step.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "kinematics/loads.h"
#include "outputs/outputs.h"

namespace gelenk {

// A force and a torque on a body, in the unit system of the scene.
struct BodyWrench {
  // load: of a force between bodies or along a joint; reaction: of a joint, its loads included.
  enum class Kind { load, reaction, contact };
  Kind kind = Kind::load;
  std::string name;  // of the element; of one that a joint has, "JOINT.GROUP"
  int body = -1;     // of the scene, on which it acts; -1: the ground
  int place = 0;     // port of a force, other body of a contact, 1: of a motor; unique together with name and body
  Eigen::Vector3d p = Eigen::Vector3d::Zero();  // m, in the body's frame: where the force acts
  Eigen::Vector3d f = Eigen::Vector3d::Zero();  // N, in the world's axes
  Eigen::Vector3d n = Eigen::Vector3d::Zero();  // N m
};

class BodyWrenches {
 public:
  // Both must outlive it.
  BodyWrenches(const Scene& scene, const ReducedScene& reduced) : scene_(scene), reduced_(reduced) {}

  // Adds those in an island at its present accelerations; reactions of the joints with a sensor that reads them. u: all
  // signals (kinematics/loads.h).
  void add(int island, const Reading& reading, const Loads& loads, const double* u);
  // Adds those of forces between immobile bodies that depend on nothing but inputs. u: these, and the clock if there is
  // one.
  void add_immobile(const std::vector<double>& u) { add_forces(Outputs::none, nullptr, nullptr, u.data()); }

  std::vector<BodyWrench> all;

 private:
  int body_of(const BodyFrame& frame) const;
  Pose3 X_WB(int body, const Readings<double>& dynamics) const;
  bool bind_to_inputs(Formula& formula, int first_input) const;
  template <class F>
  bool act(const F& element, RecordingPort<double>* at, const Loads* loads, const double* u, int force) const;
  void add_forces(int island, const Readings<double>* dynamics, const Loads* loads, const double* u);
  void add_along_joints(const Reading& reading, const Mechanism& mechanism, const Loads& loads, const double* u);
  // effort [N m, N]: along a coordinate of a joint of the scene; motor: that exerts it, or -1: an element of the joint,
  // with the key `group`.
  // owner: name of the motor or component, empty for the joint.
  void add_along(int joint, int component, std::string_view owner, std::string_view group, double effort,
                 const Reading& reading);
  void add_reactions(int island, const Readings<double>& dynamics);
  void add_contacts(const Reading& reading, const Mechanism& mechanism);
  void add_law_of_joint(const ContactForce& at, const Reading& reading, const Mechanism& mechanism);

  const Scene& scene_;
  const ReducedScene& reduced_;
};

}  // namespace gelenk
