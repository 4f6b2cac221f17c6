// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>

#include "joint/base.h"
#include "math/dual.h"

namespace gelenk {

// Screw: M rotates about the common z axis of F and M and translates along it, by the pitch p per radian.
//   X_FM = Trans_z(p phi) Rot_z(phi)      V_FM = (0 0 w | 0 0 p w)      q = phi [rad], v = w [rad/s]
// If it closes a loop, the number of full turns follows from the displacement s of M: phi is the angle closest to s/p.
struct Screw : PlainJoint<1>, AlongZ {
  static constexpr std::string_view kind = "screw";
  static constexpr std::string_view summary = "rotates about an axis and translates along it with a fixed pitch";
  static constexpr PlanarRole planar = PlanarRole::never;
  static constexpr Quantity q_names[] = {{"phi", "rad", "angle of M relative to F about the axis (unwrapped)"}};
  static constexpr Quantity v_names[] = {{"w", "rad/s", "angular velocity, der(phi)"}};
  static constexpr Quantity a_names[] = {{"a", "rad/s2", "angular acceleration, der(w)"}};
  static constexpr bool reverses_by_half_turn = true;

  double pitch = 1;  // m/rad

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&Screw::pitch>({.name = "pitch",
                                                          .unit = "m/rad",
                                                          .text = "translation of M along the axis per radian",
                                                          .range = Range::not_zero,
                                                          .required = true})};
    return all;
  }

  static Screw make(std::span<const Eigen::Vector3d>) { return {}; }

  template <class A, class T>
  typename A::Pose X_FM(const T* q) const {
    typename A::Pose X;
    X.R = rotation_z(q[0]);
    X.p.z() = T(pitch) * q[0];
    return X;
  }
  template <class A, class T>
  typename A::Motion V_FM(const T*, const T* v) const {
    typename A::Motion V;
    V.w.z() = v[0];
    V.v.z() = T(pitch) * v[0];
    return V;
  }
  template <class A, class T>
  void project(const T*, const typename A::Force& F, T* tau) const {
    tau[0] = F.n.z() + T(pitch) * F.f.z();
  }
  // A pure torque: unlike the other equivalent forces it is independent of the unit of length.
  template <class A, class T>
  typename A::Force wrench_from_tau(const T*, const T* tau) const {
    typename A::Force F;
    F.n.z() = tau[0];
    return F;
  }
  template <class A, class T>
  void speeds(const T*, const typename A::Motion& V, T* v) const {
    v[0] = (V.w.z() + T(pitch) * V.v.z()) / T(1 + pitch * pitch);
  }
  template <class A>
  void coordinates(const typename A::Pose& X_FM, typename A::Scalar* q) const {
    q[0] = angle<A>(X_FM);
  }
  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    using T = typename A::Scalar;
    out[0] = rows::point<A>(X_FM, 0);
    out[1] = rows::point<A>(X_FM, 1);
    const int n = 2 + rows::parallel_z<A>(X_FM, out + 2);
    out[n].w = {};
    out[n].w.f.z() = T(1);
    out[n].w.n.z() = T(-pitch);
    out[n].Phi = X_FM.p.z() - T(pitch) * angle<A>(X_FM);
    return n + 1;
  }

 private:
  // Rotation angle with the number of full turns [rad].
  template <class A>
  typename A::Scalar angle(const typename A::Pose& X_FM) const {
    using T = typename A::Scalar;
    const T within_a_turn = angle_z<A>(X_FM);
    return within_a_turn +
           T(2 * std::numbers::pi *
             std::round((value_of(X_FM.p.z()) / pitch - value_of(within_a_turn)) / (2 * std::numbers::pi)));
  }
};

}  // namespace gelenk
