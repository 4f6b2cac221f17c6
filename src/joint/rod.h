// SPDX-License-Identifier: BSD-3-Clause
// A rod without mass between two point-like joints: it keeps two points at a distance and does nothing else.
#pragma once

#include <optional>
#include <variant>

#include "joint/registry.h"
#include "math/pose_in.h"

namespace gelenk {

// Rod: the chain of a joint, a rod and a second joint, taken as one joint that closes a loop. F is the first joint's
// frame on one neighbour, M the second's on the other; the row keeps |p_FM| at the rod's length. No scene names it and
// no tree holds it; else it obeys base.h.
//   X_FM = X_1(q_1) X_12 X_2(q_2)     q = (q_1, q_2), v = (v_1, v_2): the two joints' own, in the user's sense
//   w = (0 | e), Phi = |p| - length, e = p/|p|;   wdot . V = (|pdot|^2 - (e . pdot)^2) / |p|
// What p does not tell, the rod's turn about itself, the first joint decides: a universal joint leaves two positions,
// of which a motion keeps one (see aim() in rod.cpp); with two spherical joints nothing does, and the first is taken
// to turn by the shortest way from its reference position to the rod's direction.
struct Rod {
  // A joint seen from F outwards.
  using End =
      std::variant<Revolute, Reversed<Revolute>, Universal, Reversed<Universal>, Spherical, Reversed<Spherical>>;
  static constexpr PlanarRole planar = PlanarRole::normal;  // hinges along it; the other ends live in space
  static constexpr bool rows_turn = true;
  static constexpr int max_nq = 8, max_nv = 6;

  End first, second;
  Pose3 X_12;         // the second joint's frame on the rod, in the first's on the rod
  double length = 0;  // m, of X_12.p; in the plane

  int first_nq() const;
  int first_nv() const;
  int nq() const;
  int nv() const;
  // Does the first joint leave the rod's turn about itself open?
  bool spins() const;

  // Numbers of the algebra A.
  template <class A>
  using In = const typename A::Scalar*;
  template <class A>
  using Out = typename A::Scalar*;

  // Pose and velocity of the rod's frame, the first joint's there, against F.
  template <class A>
  typename A::Pose rod_pose(In<A> q) const;
  template <class A>
  typename A::Motion rod_velocity(In<A> q, In<A> v) const;

  template <class A>
  typename A::Pose X_FM(In<A> q) const;
  template <class A>
  typename A::Motion V_FM(In<A> q, In<A> v) const;
  template <class A>
  typename A::Motion bias(In<A> q, In<A> v) const;
  // Not where two spherical joints leave the rod's turn open: nothing could hold it against a torque.
  template <class A>
  typename A::Force wrench_from_tau(In<A> q, In<A> tau) const;
  template <class A>
  void speeds(In<A> q, const typename A::Motion& V, Out<A> v) const;
  template <class A>
  void coordinates(const typename A::Pose& X_FM, Out<A> q) const;

  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    using std::sqrt;
    using T = typename A::Scalar;
    out[0].w = {};
    if constexpr (A::planar) {
      const T p = sqrt(X_FM.px * X_FM.px + X_FM.py * X_FM.py);
      // Where both points fall together any direction will do: they must part.
      out[0].w.x = p > T(0) ? T(X_FM.px / p) : T(1);
      out[0].w.y = p > T(0) ? T(X_FM.py / p) : T(0);
      out[0].Phi = p - length;
    } else {
      const T p = X_FM.p.norm();
      out[0].w.f = p > T(0) ? Vector3<T>(X_FM.p / p) : Vector3<T>(Vector3<T>::UnitX());
      out[0].Phi = p - length;
    }
    return 1;
  }
  template <class A, class T>
  void rows_bias(const typename A::Pose& X_FM, const typename A::Motion& V, T* bias) const {
    using std::sqrt;
    if constexpr (A::planar) {
      const T p = sqrt(X_FM.px * X_FM.px + X_FM.py * X_FM.py);
      if (!(p > T(0))) return;
      const T across = (X_FM.px * V.y - X_FM.py * V.x) / p;
      bias[0] += across * across / p;
    } else {
      const T p = X_FM.p.norm();
      if (!(p > T(0))) return;
      bias[0] += (X_FM.p / p).cross(V.v).squaredNorm() / p;
    }
  }
};

// The rod between two joints, or nothing where these leave it less than every direction or hold it by more than its
// length. reversed: the joint's half M lies on the inner side, F to M being outwards (first: on the neighbour; second:
// on the rod). planar: in a plane, all frames' z along its normal.
std::optional<Rod> make_rod(const AnyJoint& first, bool first_reversed, const AnyJoint& second, bool second_reversed,
                            const Pose3& X_12, bool planar);

}  // namespace gelenk
