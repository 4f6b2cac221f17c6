// SPDX-License-Identifier: BSD-3-Clause
// A massless rod between two point-like joints, which acts as a distance constraint between two points.
#pragma once

#include <optional>
#include <variant>

#include "joint/registry.h"
#include "math/pose_in.h"

namespace gelenk {

// Rod: the chain of a joint, a rod and a second joint, treated as one joint that closes a loop. F is the first joint's
// frame on one neighbor, M the second joint's frame on the other; the constraint equation keeps |p_FM| equal to the
// length of the rod. It is not a joint type of scenes and never a tree joint; otherwise it has the interface of base.h.
//   X_FM = X_1(q_1) X_12 X_2(q_2)     q = (q_1, q_2), v = (v_1, v_2): those of the two joints, with the user's signs
//   w = (0 | e), Phi = |p| - length, e = p/|p|;   wdot . V = (|pdot|^2 - (e . pdot)^2) / |p|
// The rotation of the rod about its own axis does not follow from p. A universal joint as the first joint leaves two
// possibilities, one of which persists during a motion (see aim() in rod.cpp). With two spherical joints the rotation
// is free; the first joint is then assumed to rotate by the shortest way from its reference position.
struct Rod {
  // A joint at an end of the rod, directed outwards from F.
  using End =
      std::variant<Revolute, Reversed<Revolute>, Universal, Reversed<Universal>, Spherical, Reversed<Spherical>>;
  static constexpr PlanarRole planar = PlanarRole::normal;  // of hinges; the other ends are for spatial mechanisms
  static constexpr bool rows_turn = true;
  static constexpr int max_nq = 8, max_nv = 6;

  End first, second;
  Pose3 X_12;         // the second joint's frame on the rod in the first joint's frame on the rod
  double length = 0;  // |X_12.p| [m]; in a plane without the normal component

  int first_nq() const;
  int first_nv() const;
  int nq() const;
  int nv() const;
  // Whether the rod can rotate freely about its own axis (two spherical joints).
  bool has_free_spin() const;

  // Pointers to coordinates, velocities or generalized forces.
  template <class A>
  using In = const typename A::Scalar*;
  template <class A>
  using Out = typename A::Scalar*;

  // Pose and velocity of the rod, at the first joint's frame on it, relative to F.
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
  // Not defined if has_free_spin(), since nothing supports a torque about the axis of the rod.
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
      // If both points coincide, any direction separates them.
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

// Returns the rod between two joints, or nothing if it cannot reach all directions or if the joints constrain more than
// the distance. X_12: pose of the second joint's frame on the rod in the first joint's frame on the rod. reversed: M of
// the joint, not F, is on the inner side (first: on the neighbor; second: on the rod). planar: mechanism in a plane,
// with z of all frames along its normal.
std::optional<Rod> make_rod(const AnyJoint& first, bool first_reversed, const AnyJoint& second, bool second_reversed,
                            const Pose3& X_12, bool planar);

}  // namespace gelenk
