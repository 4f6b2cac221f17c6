// SPDX-License-Identifier: BSD-3-Clause
// What outputs are read from, on numbers T: double, or such that carry derivatives.
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

  // Cut joints: speeds (after set_velocity), accelerations (after set_acceleration).
  virtual void cut_speeds(int cut, T* v) const = 0;
  virtual void cut_accelerations(int cut, T* a) const = 0;

  virtual EnergyOf<T> energy() const = 0;  // after set_velocity and set_root_poses

  // Pose of a link in the root frame (the ground link's; after set_root_poses), velocity in the link's frame.
  virtual Pose link_pose(int link) const = 0;
  virtual Motion link_velocity(int link) const = 0;
  // The same for the frame of a rod that has become a cut.
  virtual Pose rod_pose(int cut) const = 0;
  virtual Motion rod_velocity(int cut) const = 0;
  // Wrench of tree joint `link` on its outer link, or of a cut joint on link b, at that half's frame, in it;
  // drives and springs along the joint included. After set_acceleration; spatial algebra only.
  virtual Force tree_reaction(int link) const = 0;
  virtual Force cut_reaction(int cut) const = 0;
  // Forces of constraints, after set_acceleration: along row i of a contact, and of a coordinate row where its factor
  // is 1. N or N m.
  virtual T contact_force(int cut, int i) const = 0;
  virtual T coordinate_force(int row) const = 0;
  // Of a constraint between bodies: its plane F in the root frame, after set_root_poses; M in F.
  virtual Pose plane_pose(int cut) const = 0;
  virtual Pose pose_on_plane(int cut) const = 0;
};

}  // namespace gelenk
