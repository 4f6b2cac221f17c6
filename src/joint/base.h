// SPDX-License-Identifier: BSD-3-Clause
// The interface of a joint, and base classes with the parts that most joints share.
//
// A joint is a small struct with static data (revolute.h is the shortest example) and these functions, templates on the
// algebra A (planar.h, spatial.h) or its number type T. M is also the frame of the link. q, v, tau: nq, nv, nv numbers.
//
//   X_FM<A>(q)                 pose of M in F
//   V_FM<A>(q, v)              S v: velocity of M in F, written in M
//   bias<A>(q, v)              Sdot v, componentwise in M
//   project<A>(q, F, tau)      tau = S^T F, F on M in M
//   wrench_from_tau<A>(q, tau) a force F on M in M, in the span of S, with project(q, F) = tau
//   speeds<A>(q, V, v)         the v with S v = V, for V in the span of S; otherwise the least-squares solution
//   qdot_from_v(q, v, qdot)    qdot = N(q) v;   v_from_qdot(q, qdot, v) is its inverse
//   normalize(q)               removes redundancy from q (the length of a quaternion)
//   coordinates<A>(X_FM, q)    q of a pose that the joint permits; on entry q is the previous value (for the sign of a
//                              quaternion)
//   rows<A>(X_FM, row)         writes the constraint equations (rows.h) and returns their number, A::dimension - nv
//   rows_bias<A>(X_FM, V, b)   b += wdot . V_FM, with V as in rows.h
//
// Static data:
//   reverses_by_half_turn  whether a rotation of both frames by half a turn about x exchanges the roles of F and M
//                          (revolute, prismatic, ...); the other joints are reversed by Reversed<J> (reversed.h)
//   constant_S             whether S is constant in M
//   shifts_in_F            if S is not constant: number of leading velocities that are translations along axes fixed in
//                          F; 0 if S varies in another way
//   rows_turn              whether the wrenches of the constraint equations depend on X_FM
//   pure_turn              whether S is the rotation about the z axis of M, with qdot = v; optional
//   q_zero                 q with X_FM = 1
//
// make(axes) builds the joint from unit axes in the user's joint frame U; canonical(axes) returns R_UC, the rotation
// from U to the frame C of the joint's own formulas, in which most joints have their axis along z.
#pragma once

#include "joint/kind.h"
#include "joint/rows.h"

namespace gelenk {

// Base class of joints with qdot = v; by default with a motion space that is constant in M.
template <int n>
struct PlainJoint {
  static constexpr int nq = n, nv = n;
  static constexpr double q_zero[n > 0 ? n : 1] = {};
  static constexpr bool constant_S = true, rows_turn = false;
  static constexpr int shifts_in_F = 0;

  template <class A, class T>
  typename A::Motion bias(const T*, const T*) const {
    return {};
  }
  template <class T>
  void qdot_from_v(const T*, const T* v, T* qdot) const {
    for (int i = 0; i < n; ++i) qdot[i] = v[i];
  }
  template <class T>
  void v_from_qdot(const T*, const T* qdot, T* v) const {
    for (int i = 0; i < n; ++i) v[i] = qdot[i];
  }
  template <class T>
  void normalize(T*) const {}
  template <class A, class T>
  void rows_bias(const typename A::Pose&, const typename A::Motion&, T*) const {}
};

template <class J>
constexpr bool is_pure_turn = requires { requires J::pure_turn; };

// The force with the components of a motion; S tau for joints with S^T S = 1.
template <class A>
typename A::Force as_force(const typename A::Motion& V) {
  if constexpr (A::planar) {
    return {V.w, V.x, V.y};
  } else {
    return {V.w, V.v};
  }
}

// Base class of joints with one axis, the z axis of F and M.
struct AlongZ {
  static constexpr int axes = 1;
  static Eigen::Matrix3d canonical(std::span<const Eigen::Vector3d> axes) { return rotation_taking_z_to(axes[0]); }
};

// Base class of joints without an axis.
struct NoAxis {
  static constexpr int axes = 0;
  static Eigen::Matrix3d canonical(std::span<const Eigen::Vector3d>) { return Eigen::Matrix3d::Identity(); }
};

// Rotation matrix of a rotation about z by phi [rad].
template <class T>
Matrix3<T> rotation_z(const T& phi) {
  using std::cos;
  using std::sin;
  Matrix3<T> R;
  R << cos(phi), -sin(phi), T(0), sin(phi), cos(phi), T(0), T(0), T(0), T(1);
  return R;
}
// Angle of the pose's rotation about z [rad], in [-pi, pi].
template <class A>
typename A::Scalar angle_z(const typename A::Pose& X) {
  using std::atan2;
  if constexpr (A::planar) {
    return atan2(X.s, X.c);
  } else {
    return atan2(X.R(1, 0) - X.R(0, 1), X.R(0, 0) + X.R(1, 1));
  }
}

}  // namespace gelenk
