// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "joint/base.h"

namespace gelenk {

// Revolute: M rotates about the common z axis of F and M.
//   X_FM = Rot_z(phi)      V_FM = (0 0 w | 0 0 0)      q = phi [rad], v = w [rad/s]
struct Revolute : PlainJoint<1>, AlongZ {
  static constexpr std::string_view kind = "revolute";
  static constexpr std::string_view summary = "rotates about an axis";
  static constexpr PlanarRole planar = PlanarRole::normal;
  static constexpr Quantity q_names[] = {{"phi", "rad", "angle of M relative to F about the axis (unwrapped)"}};
  static constexpr Quantity v_names[] = {{"w", "rad/s", "angular velocity, der(phi)"}};
  static constexpr Quantity a_names[] = {{"a", "rad/s2", "angular acceleration, der(w)"}};
  static constexpr bool reverses_by_half_turn = true;
  static constexpr bool pure_turn = true;
  static constexpr double flip[] = {-1};  // sign of q and v after half a turn of F and M about x

  static Revolute make(std::span<const Eigen::Vector3d>) { return {}; }

  template <class A, class T>
  typename A::Pose X_FM(const T* q) const {
    using std::cos;
    using std::sin;
    typename A::Pose X;
    if constexpr (A::planar) {
      X.c = cos(q[0]);
      X.s = sin(q[0]);
    } else {
      X.R = rotation_z(q[0]);
    }
    return X;
  }
  template <class A, class T>
  typename A::Motion V_FM(const T*, const T* v) const {
    typename A::Motion V;
    if constexpr (A::planar) {
      V.w = v[0];
    } else {
      V.w.z() = v[0];
    }
    return V;
  }
  template <class A, class T>
  void project(const T*, const typename A::Force& F, T* tau) const {
    if constexpr (A::planar) {
      tau[0] = F.n;
    } else {
      tau[0] = F.n.z();
    }
  }
  template <class A, class T>
  typename A::Force wrench_from_tau(const T* q, const T* tau) const {
    return as_force<A>(V_FM<A>(q, tau));
  }
  template <class A, class T>
  void speeds(const T*, const typename A::Motion& V, T* v) const {
    if constexpr (A::planar) {
      v[0] = V.w;
    } else {
      v[0] = V.w.z();
    }
  }
  template <class A>
  void coordinates(const typename A::Pose& X_FM, typename A::Scalar* q) const {
    q[0] = angle_z<A>(X_FM);
  }
  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    const int n = rows::coincident<A>(X_FM, out);
    return n + rows::parallel_z<A>(X_FM, out + n);
  }
};

}  // namespace gelenk
