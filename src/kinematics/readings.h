// SPDX-License-Identifier: BSD-3-Clause
// Quantities from which outputs are read. T: double, Dual or Series.
#pragma once

#include "math/spatial.h"

namespace gelenk {

template <class T>
struct EnergyOf {
  T kinetic{0};    // J
  T potential{0};  // J, of gravity (zero at the world's origin), springs and stops
};
using Energy = EnergyOf<double>;

template <class T>
class Readings {
 public:
  using Pose = typename SpatialAlgebra<T>::Pose;
  using Motion = typename SpatialAlgebra<T>::Motion;
  using Force = typename SpatialAlgebra<T>::Force;

  virtual ~Readings() = default;

  // Velocities (after set_velocity) and accelerations (after set_acceleration) of a cut joint.
  virtual void cut_speeds(int cut, T* v) const = 0;
  virtual void cut_accelerations(int cut, T* a) const = 0;

  virtual EnergyOf<T> energy() const = 0;  // after set_velocity and set_root_poses
  // The rates of the element states under these signals (loads.h), after set_velocity; 0 for those that name forces.
  virtual void state_rates(const T* u, T* out) = 0;
  virtual void expression_values(const T* u, T* out) = 0;  // the same of the named expressions that name no forces

  // Pose of a link in the root frame (that of the ground link), after set_root_poses; velocity, in the link's frame.
  virtual Pose link_pose(int link) const = 0;
  virtual Motion link_velocity(int link) const = 0;
  // The rates of these components, after set_acceleration and set_root_poses.
  virtual Motion link_acceleration(int link) const = 0;
  // The same for the frame of a massless rod that has become a cut.
  virtual Pose rod_pose(int cut) const = 0;
  virtual Motion rod_velocity(int cut) const = 0;
  // Wrench of tree joint `link` on its outer link, or of a cut joint on link b, about and in the joint's frame on that
  // link, including motors and springs along the joint. After set_acceleration; spatial algebra only.
  virtual Force tree_reaction(int link) const = 0;
  virtual Force cut_reaction(int cut) const = 0;
  // Constraint forces [N or N m], after set_acceleration: of equation i of a contact, and of a coordinate constraint
  // (the generalized force on a coordinate with factor 1).
  virtual T contact_force(int cut, int i) const = 0;
  virtual T coordinate_force(int row) const = 0;
  // Forces [N m, N] of all elements with modes along joints, in the user's signs, after set_velocity. u: all signals
  // (kinematics/loads.h); sides: their modes (JointLoads::add); holding: for those that keep their coordinate at rest,
  // the force with which they do.
  virtual void switching_forces(const T* u, const int* sides, const T* holding, T* out) const = 0;
  // Poses of a constraint between bodies, after set_root_poses: its plane F in the root frame; M in F.
  virtual Pose plane_pose(int cut) const = 0;
  virtual Pose pose_on_plane(int cut) const = 0;
};

}  // namespace gelenk
