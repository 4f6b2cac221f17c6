// SPDX-License-Identifier: BSD-3-Clause
// The interface of a joint, and the parts of it that most joints share.
//
// A joint is a small struct of static facts (see revolute.h for the shortest) and these functions,
// templates on the algebra A (planar.h, spatial.h) or its number type T. M is also the body's frame:
//
//   X_FM<A>(q)                 pose of M in F
//   V_FM<A>(q, v)              S v: velocity of M in F, written in M
//   bias<A>(q, v)              Sdot v, componentwise in M
//   project<A>(q, F, tau)      tau = S^T F, F on M in M
//   effort<A>(q, tau)          a force F, in the span of S, with project(q, F) = tau
//   speeds<A>(q, V, v)         the v with S v = V, V in the span of S (else the nearest)
//   rate(q, v, qdot)           qdot = N(q) v;   v_from_qdot(q, qdot, v) its inverse
//   normalize(q)               removes what is redundant in q (a quaternion's length)
//   coordinates<A>(X_FM, q)    q of an allowed pose; on entry q holds the last value (a quaternion's sign)
//   rows<A>(X_FM, row)         what the joint forbids (rows.h), A::dimension - nv of them; returns the number
//   rows_bias<A>(X_FM, V, b)   b += wdot . V_FM, with V as in rows.h
//
// turned is true where turning both halves half a turn about x exchanges their roles (revolute, prismatic, ...):
// the other joints are exchanged by Reversed<J> (reversed.h).
// For derivatives it says how S looks from M: constant_S, or, where it is not, shifts_in_F: how many of its first
// speeds are shifts along axes that stay in F (0: S changes in some other way); and rows_turn: the rows' wrenches turn
// with X_FM.
//
// pure_turn is true where the motion space is the turn about M's z axis and qdot = v; may be left out otherwise.
//
// make(axes) builds the joint from the user's unit axes, canonical(axes) gives R_UC, the turn from
// the user's joint frame to the one the joint is written in (most have the axis along z).
#pragma once

#include "joint/kind.h"
#include "joint/rows.h"

namespace gelenk {

// Joints whose motion space is constant in M and whose speeds are the rates of their coordinates.
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

// For joints with S^T S = 1: the force that S tau is.
template <class A>
typename A::Force as_force(const typename A::Motion& V) {
  if constexpr (A::planar) {
    return {V.w, V.x, V.y};
  } else {
    return {V.w, V.v};
  }
}

// Joints with one axis, the z axis of F and M.
struct AlongZ {
  static constexpr int axes = 1;
  static Eigen::Matrix3d canonical(std::span<const Eigen::Vector3d> axes) { return rotation_taking_z_to(axes[0]); }
};

// Joints without an axis.
struct NoAxis {
  static constexpr int axes = 0;
  static Eigen::Matrix3d canonical(std::span<const Eigen::Vector3d>) { return Eigen::Matrix3d::Identity(); }
};

// Pieces of poses that several joints use.
template <class T>
Matrix3<T> rotation_z(const T& phi) {
  using std::cos;
  using std::sin;
  Matrix3<T> R;
  R << cos(phi), -sin(phi), T(0), sin(phi), cos(phi), T(0), T(0), T(0), T(1);
  return R;
}
// The angle of a turn about z.
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
