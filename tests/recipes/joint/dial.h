// SPDX-License-Identifier: BSD-3-Clause
// Example of a joint with a parameter of its own; tests/test_recipes.py adds it.
#pragma once

#include "joint/base.h"

namespace gelenk {

// Dial: M rotates about the common z axis of F and M by c times the coordinate.
//   X_FM = Rot_z(c phi)      V_FM = (0 0 c w | 0 0 0)      q = phi [rad], v = w [rad/s]
struct Dial : PlainJoint<1>, AlongZ {
  static constexpr std::string_view kind = "dial";
  static constexpr std::string_view summary = "geared rotation about an axis";
  static constexpr PlanarRole planar = PlanarRole::never;
  static constexpr Quantity q_names[] = {{"phi", "rad", "angle of the dial"}};
  static constexpr Quantity v_names[] = {{"w", "rad/s", "angular velocity of the dial, der(phi)"}};
  static constexpr Quantity a_names[] = {{"a", "rad/s2", "angular acceleration of the dial, der(w)"}};
  static constexpr bool reverses_by_half_turn = true;

  double ratio = 1;  // -

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&Dial::ratio>({.name = "ratio",
                                                         .unit = "1",
                                                         .text = "rotation of M per rotation of the dial",
                                                         .range = Range::not_zero,
                                                         .required = true})};
    return all;
  }

  static Dial make(std::span<const Eigen::Vector3d>) { return {}; }

  template <class A, class T>
  typename A::Pose X_FM(const T* q) const {
    typename A::Pose X;
    X.R = rotation_z(T(T(ratio) * q[0]));
    return X;
  }
  template <class A, class T>
  typename A::Motion V_FM(const T*, const T* v) const {
    typename A::Motion V;
    V.w.z() = T(ratio) * v[0];
    return V;
  }
  template <class A, class T>
  void project(const T*, const typename A::Force& F, T* tau) const {
    tau[0] = T(ratio) * F.n.z();
  }
  template <class A, class T>
  typename A::Force wrench_from_tau(const T*, const T* tau) const {
    typename A::Force F;
    F.n.z() = tau[0] / T(ratio);
    return F;
  }
  template <class A, class T>
  void speeds(const T*, const typename A::Motion& V, T* v) const {
    v[0] = V.w.z() / T(ratio);
  }
  template <class A>
  void coordinates(const typename A::Pose& X_FM, typename A::Scalar* q) const {
    q[0] = angle_z<A>(X_FM) / typename A::Scalar(ratio);
  }
  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    const int n = rows::coincident<A>(X_FM, out);
    return n + rows::parallel_z<A>(X_FM, out + n);
  }
};

}  // namespace gelenk
