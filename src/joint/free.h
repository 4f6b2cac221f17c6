// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "joint/base.h"
#include "joint/quaternion.h"

namespace gelenk {

// Free: all six degrees of freedom.
//   X_FM = Trans(r) Rot(Q)      V_FM = (w | R^T v)
//   q = (r [m] in F, Q), v = (v = rdot [m/s] in F, w [rad/s] in M)
// v is written in F, so that vdot of a body in free flight does not depend on its rotation.
//   Sdot v = (0 | -w x R^T v).
struct Free : NoAxis {
  static constexpr int nq = 7, nv = 6;
  static constexpr std::string_view kind = "free";
  static constexpr std::string_view summary = "moves freely in space";
  static constexpr PlanarRole planar = PlanarRole::never;
  static constexpr Quantity q_names[] = {{"r[1]", "m", "position of M in F, x"},
                                         {"r[2]", "m", "position of M in F, y"},
                                         {"r[3]", "m", "position of M in F, z"},
                                         {"Q[1]", "1", "unit quaternion of M in F, x"},
                                         {"Q[2]", "1", "unit quaternion of M in F, y"},
                                         {"Q[3]", "1", "unit quaternion of M in F, z"},
                                         {"Q[4]", "1", "unit quaternion of M in F, scalar part"}};
  static constexpr Quantity v_names[] = {{"v[1]", "m/s", "velocity, der(r[1])"},
                                         {"v[2]", "m/s", "velocity, der(r[2])"},
                                         {"v[3]", "m/s", "velocity, der(r[3])"},
                                         {"w[1]", "rad/s", "angular velocity of M in F, along M's x axis"},
                                         {"w[2]", "rad/s", "angular velocity of M in F, along M's y axis"},
                                         {"w[3]", "rad/s", "angular velocity of M in F, along M's z axis"}};
  static constexpr Quantity a_names[] = {
      {"a[1]", "m/s2", "acceleration, der(v[1])"},           {"a[2]", "m/s2", "acceleration, der(v[2])"},
      {"a[3]", "m/s2", "acceleration, der(v[3])"},           {"z[1]", "rad/s2", "angular acceleration, der(w[1])"},
      {"z[2]", "rad/s2", "angular acceleration, der(w[2])"}, {"z[3]", "rad/s2", "angular acceleration, der(w[3])"}};
  static constexpr bool reverses_by_half_turn = false, constant_S = false, rows_turn = false;
  static constexpr int shifts_in_F = 3;
  static constexpr double q_zero[] = {0, 0, 0, 0, 0, 0, 1};

  static Free make(std::span<const Eigen::Vector3d>) { return {}; }

  template <class A, class T>
  typename A::Pose X_FM(const T* q) const {
    return {quaternion::rotation(q + 3), Vector3<T>(q[0], q[1], q[2])};
  }
  template <class A, class T>
  typename A::Motion V_FM(const T* q, const T* v) const {
    return {Vector3<T>(v[3], v[4], v[5]), quaternion::rotation(q + 3).transpose() * Vector3<T>(v[0], v[1], v[2])};
  }
  template <class A, class T>
  typename A::Motion bias(const T* q, const T* v) const {
    const typename A::Motion V = V_FM<A>(q, v);
    return {Vector3<T>::Zero(), V.v.cross(V.w)};
  }
  template <class A, class T>
  void project(const T* q, const typename A::Force& F, T* tau) const {
    const Vector3<T> f = quaternion::rotation(q + 3) * F.f;
    for (int i = 0; i < 3; ++i) {
      tau[i] = f[i];
      tau[3 + i] = F.n[i];
    }
  }
  template <class A, class T>
  typename A::Force wrench_from_tau(const T* q, const T* tau) const {
    return as_force<A>(V_FM<A>(q, tau));
  }
  template <class A, class T>
  void speeds(const T* q, const typename A::Motion& V, T* v) const {
    project<A>(q, as_force<A>(V), v);  // S^T S = 1
  }
  template <class T>
  void qdot_from_v(const T* q, const T* v, T* qdot) const {
    for (int i = 0; i < 3; ++i) qdot[i] = v[i];
    quaternion::qdot_from_v(q + 3, v + 3, qdot + 3);
  }
  template <class T>
  void v_from_qdot(const T* q, const T* qdot, T* v) const {
    for (int i = 0; i < 3; ++i) v[i] = qdot[i];
    quaternion::v_from_qdot(q + 3, qdot + 3, v + 3);
  }
  template <class T>
  void normalize(T* q) const {
    quaternion::normalize(q + 3);
  }
  template <class A>
  void coordinates(const typename A::Pose& X_FM, typename A::Scalar* q) const {
    for (int i = 0; i < 3; ++i) q[i] = X_FM.p[i];
    quaternion::from_rotation(X_FM.R, q + 3);
  }
  template <class A>
  int rows(const typename A::Pose&, Row<A>*) const {
    return 0;
  }
  template <class A, class T>
  void rows_bias(const typename A::Pose&, const typename A::Motion&, T*) const {}
};

}  // namespace gelenk
