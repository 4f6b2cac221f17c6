// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "joint/base.h"

namespace gelenk {

// Cylindrical: M translates along and rotates about the common z axis of F and M, independently.
//   X_FM = Trans_z(s) Rot_z(phi)      V_FM = (0 0 w | 0 0 v)      q = (s [m], phi [rad]), v = (v [m/s], w [rad/s])
struct Cylindrical : PlainJoint<2>, AlongZ {
  static constexpr std::string_view kind = "cylindrical";
  static constexpr std::string_view summary = "translates along and rotates about one axis";
  static constexpr PlanarRole planar = PlanarRole::never;
  static constexpr Quantity q_names[] = {{"s", "m", "displacement of M relative to F along the axis"},
                                         {"phi", "rad", "angle of M relative to F about the axis (unwrapped)"}};
  static constexpr Quantity v_names[] = {{"v", "m/s", "velocity, der(s)"},
                                         {"w", "rad/s", "angular velocity, der(phi)"}};
  static constexpr Quantity a_names[] = {{"a", "m/s2", "acceleration, der(v)"},
                                         {"wd", "rad/s2", "angular acceleration, der(w)"}};
  static constexpr bool reverses_by_half_turn = true;

  static Cylindrical make(std::span<const Eigen::Vector3d>) { return {}; }

  template <class A, class T>
  typename A::Pose X_FM(const T* q) const {
    typename A::Pose X;
    X.R = rotation_z(q[1]);
    X.p.z() = q[0];
    return X;
  }
  template <class A, class T>
  typename A::Motion V_FM(const T*, const T* v) const {
    typename A::Motion V;
    V.v.z() = v[0];
    V.w.z() = v[1];
    return V;
  }
  template <class A, class T>
  void project(const T*, const typename A::Force& F, T* tau) const {
    tau[0] = F.f.z();
    tau[1] = F.n.z();
  }
  template <class A, class T>
  typename A::Force wrench_from_tau(const T* q, const T* tau) const {
    return as_force<A>(V_FM<A>(q, tau));
  }
  template <class A, class T>
  void speeds(const T*, const typename A::Motion& V, T* v) const {
    v[0] = V.v.z();
    v[1] = V.w.z();
  }
  template <class A>
  void coordinates(const typename A::Pose& X_FM, typename A::Scalar* q) const {
    q[0] = X_FM.p.z();
    q[1] = angle_z<A>(X_FM);
  }
  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    out[0] = rows::point<A>(X_FM, 0);
    out[1] = rows::point<A>(X_FM, 1);
    return 2 + rows::parallel_z<A>(X_FM, out + 2);
  }
};

}  // namespace gelenk
