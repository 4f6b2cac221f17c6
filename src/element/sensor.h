// SPDX-License-Identifier: BSD-3-Clause
// What is measured. A sensor changes no motion; the bodies at its ports are solved together. It offers outputs and
//
//   output(seen, group, i)   component i of a group of its outputs
//
// where seen is, of numbers T,
//   pose(k)                  X_0P of its k-th frame, or of those of its joint, F then M, in a frame 0 that stands still
//   frame(k)                 the same with the velocity of its origin and its angular velocity, along the axes of 0
//   X_W0()                   the pose of that frame in the world
//   reaction()               force [N] and torque [N m] of the joint on its child body at M, drives and springs along
//   the
//                            joint included, along the axes of 0; only with reads_reaction
//   energy()                 kinetic and potential [J], of the whole mechanism; only with of_whole
#pragma once

#include "element/element.h"

namespace gelenk {

template <class S>
concept ReadsReaction = requires { requires S::reads_reaction; };
template <class S>
concept OfWhole = requires { requires S::of_whole; };

// A frame as it is seen.
template <class T>
struct SeenFrame {
  typename SpatialAlgebra<T>::Pose X_0P;
  Vector3<T> v, w;  // m/s, rad/s
};

// Component i of a rotation's unit quaternion, x, y, z, scalar part; that not negative: one of the two that mean the
// same.
template <class T>
T quaternion_component(const Matrix3<T>& R, int i) {
  Eigen::Quaternion<T> Q(R);
  if (Q.w() < T(0)) Q.coeffs() = -Q.coeffs();
  return Q.coeffs()[i];
}

}  // namespace gelenk
