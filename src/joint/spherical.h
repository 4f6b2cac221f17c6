// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "joint/base.h"
#include "joint/isotropic_friction.h"
#include "joint/quaternion.h"
#include "joint/swing_limit.h"

namespace gelenk {

// Spherical: M rotates about any axis through the common origin of F and M.
//   X_FM = Rot(Q)      V_FM = (w | 0)      q = Q (quaternion.h), v = w [rad/s] in M, qdot = 1/2 Q (w, 0)
struct Spherical : NoAxis {
  static constexpr int nq = 4, nv = 3;
  static constexpr std::string_view kind = "spherical";
  static constexpr std::string_view summary = "rotates about any axis through a point";
  static constexpr PlanarRole planar = PlanarRole::never;
  static constexpr Quantity q_names[] = {{"Q[1]", "1", "unit quaternion of M in F, x"},
                                         {"Q[2]", "1", "unit quaternion of M in F, y"},
                                         {"Q[3]", "1", "unit quaternion of M in F, z"},
                                         {"Q[4]", "1", "unit quaternion of M in F, scalar part"}};
  static constexpr Quantity v_names[] = {{"w[1]", "rad/s", "angular velocity of M in F, along M's x axis"},
                                         {"w[2]", "rad/s", "angular velocity of M in F, along M's y axis"},
                                         {"w[3]", "rad/s", "angular velocity of M in F, along M's z axis"}};
  static constexpr Quantity a_names[] = {{"z[1]", "rad/s2", "angular acceleration, der(w[1])"},
                                         {"z[2]", "rad/s2", "angular acceleration, der(w[2])"},
                                         {"z[3]", "rad/s2", "angular acceleration, der(w[3])"}};
  static constexpr bool reverses_by_half_turn = false, constant_S = true, rows_turn = false;
  static constexpr int shifts_in_F = 0;
  static constexpr double q_zero[] = {0, 0, 0, 1};

  std::optional<SwingLimit> limit;
  std::optional<IsotropicFriction<true>> friction;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Spherical::limit>({.name = "limit", .text = "hard limit of its swing, with impacts"}),
        field<&Spherical::friction>({.name = "friction", .text = "dry friction, a moment about any axis"})};
    return all;
  }
  std::optional<ElementFault> fault() const {
    if (limit) {
      if (std::optional<ElementFault> found = limit->fault()) return found;
    }
    return friction ? friction->fault("friction") : std::nullopt;
  }
  std::vector<FrictionPart> friction_parts() const {
    if (!friction) return {};
    return {friction_part("friction", 3, *friction)};
  }

  static Spherical make(std::span<const Eigen::Vector3d>) { return {}; }

  template <class A, class T>
  typename A::Pose X_FM(const T* q) const {
    typename A::Pose X;
    X.R = quaternion::rotation(q);
    return X;
  }
  template <class A, class T>
  typename A::Motion V_FM(const T*, const T* v) const {
    typename A::Motion V;
    V.w << v[0], v[1], v[2];
    return V;
  }
  template <class A, class T>
  typename A::Motion bias(const T*, const T*) const {
    return {};
  }
  template <class A, class T>
  void project(const T*, const typename A::Force& F, T* tau) const {
    for (int i = 0; i < 3; ++i) tau[i] = F.n[i];
  }
  template <class A, class T>
  typename A::Force wrench_from_tau(const T* q, const T* tau) const {
    return as_force<A>(V_FM<A>(q, tau));
  }
  template <class A, class T>
  void speeds(const T*, const typename A::Motion& V, T* v) const {
    for (int i = 0; i < 3; ++i) v[i] = V.w[i];
  }
  template <class T>
  void qdot_from_v(const T* q, const T* v, T* qdot) const {
    quaternion::qdot_from_v(q, v, qdot);
  }
  template <class T>
  void v_from_qdot(const T* q, const T* qdot, T* v) const {
    quaternion::v_from_qdot(q, qdot, v);
  }
  template <class T>
  void normalize(T* q) const {
    quaternion::normalize(q);
  }
  template <class A>
  void coordinates(const typename A::Pose& X_FM, typename A::Scalar* q) const {
    quaternion::from_rotation(X_FM.R, q);
  }
  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    return rows::coincident<A>(X_FM, out);
  }
  template <class A, class T>
  void rows_bias(const typename A::Pose&, const typename A::Motion&, T*) const {}
};

}  // namespace gelenk
