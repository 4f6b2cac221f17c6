// SPDX-License-Identifier: BSD-3-Clause
// The interface of sensors. A sensor does not change the motion; the bodies at its ports belong to one island. It has
// outputs and
//
//   output(seen, group, i)   component i of an output group
//
// where seen, with numbers of type T, offers
//   pose(k)                  pose X_0P, in a fixed frame 0, of port k or of frame F (k = 0) or M (k = 1) of its joint
//   frame(k)                 the same with the velocity of its origin and its angular velocity, in the axes of 0
//   acceleration(k)          acceleration of its origin and its angular acceleration, in the axes of 0; only with
//                            reads_acceleration
//   gravity()                uniform gravity in the axes of 0 [m/s2]; only with reads_gravity
//   X_W0()                   pose of frame 0 in the world
//   reaction()               force [N] and torque [N m] of the joint on its child body at M, including drives and
//                            springs along the joint, in the axes of 0; only with reads_reaction
//   energy()                 kinetic and potential energy [J] of the whole mechanism; only with of_whole
#pragma once

#include "element/element.h"

namespace gelenk {

template <class S>
concept ReadsReaction = requires { requires S::reads_reaction; };
template <class S>
concept ReadsAcceleration = requires { requires S::reads_acceleration; };
template <class S>
concept ReadsGravity = requires { requires S::reads_gravity; };
template <class S>
concept OfWhole = requires { requires S::of_whole; };

// Pose and velocity of a frame as a sensor reads them.
template <class T>
struct SeenFrame {
  typename SpatialAlgebra<T>::Pose X_0P;
  Vector3<T> v, w;  // m/s, rad/s
};

template <class T>
struct SeenAcceleration {
  Vector3<T> a, alpha;  // m/s2, rad/s2
};

// Component i of the unit quaternion of R: x, y, z, scalar part. Of the two quaternions of a rotation, the one with a
// nonnegative scalar part.
template <class T>
T quaternion_component(const Matrix3<T>& R, int i) {
  Eigen::Quaternion<T> Q(R);
  if (Q.w() < T(0)) Q.coeffs() = -Q.coeffs();
  return Q.coeffs()[i];
}

}  // namespace gelenk
