// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "joint/base.h"

namespace gelenk {

// Prismatic: M translates along the common z axis of F and M (in planar algebra: along x).
//   X_FM = Trans_z(s)      V_FM = (0 0 0 | 0 0 v)      q = s [m], v = v [m/s]
struct Prismatic : PlainJoint<1>, AlongZ {
  static constexpr std::string_view kind = "prismatic";
  static constexpr std::string_view summary = "translates along an axis";
  static constexpr PlanarRole planar = PlanarRole::in_plane;
  static constexpr Quantity q_names[] = {{"s", "m", "displacement of M relative to F along the axis"}};
  static constexpr Quantity v_names[] = {{"v", "m/s", "velocity, der(s)"}};
  static constexpr Quantity a_names[] = {{"a", "m/s2", "acceleration, der(v)"}};
  static constexpr bool reverses_by_half_turn = true;
  static constexpr double flip[] = {1};

  static Prismatic make(std::span<const Eigen::Vector3d>) { return {}; }

  template <class A, class T>
  typename A::Pose X_FM(const T* q) const {
    typename A::Pose X;
    if constexpr (A::planar) {
      X.px = q[0];
    } else {
      X.p.z() = q[0];
    }
    return X;
  }
  template <class A, class T>
  typename A::Motion V_FM(const T*, const T* v) const {
    typename A::Motion V;
    if constexpr (A::planar) {
      V.x = v[0];
    } else {
      V.v.z() = v[0];
    }
    return V;
  }
  template <class A, class T>
  void project(const T*, const typename A::Force& F, T* tau) const {
    if constexpr (A::planar) {
      tau[0] = F.x;
    } else {
      tau[0] = F.f.z();
    }
  }
  template <class A, class T>
  typename A::Force wrench_from_tau(const T* q, const T* tau) const {
    return as_force<A>(V_FM<A>(q, tau));
  }
  template <class A, class T>
  void speeds(const T*, const typename A::Motion& V, T* v) const {
    if constexpr (A::planar) {
      v[0] = V.x;
    } else {
      v[0] = V.v.z();
    }
  }
  template <class A>
  void coordinates(const typename A::Pose& X_FM, typename A::Scalar* q) const {
    if constexpr (A::planar) {
      q[0] = X_FM.px;
    } else {
      q[0] = X_FM.p.z();
    }
  }
  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    int n = 0;
    if constexpr (A::planar) {
      out[n++] = rows::point<A>(X_FM, 1);
    } else {
      out[n++] = rows::point<A>(X_FM, 0);
      out[n++] = rows::point<A>(X_FM, 1);
    }
    return n + rows::no_turn<A>(X_FM, out + n);
  }
};

}  // namespace gelenk
