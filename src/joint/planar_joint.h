// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "joint/base.h"
#include "joint/isotropic_friction.h"

namespace gelenk {

// Planar: M translates in the x-y plane of F and rotates about its normal z.
//   X_FM = Trans(s_x, s_y, 0) Rot_z(phi)      V_FM = (0 0 w | Rot_z^T (v_x v_y 0))
//   q = (s_x [m], s_y [m], phi [rad]), v = qdot, written in F, so that a body in free motion has constant velocities.
//   Sdot v = (0 | -w z x Rot_z^T (v_x v_y 0)).
struct PlanarJoint : PlainJoint<3>, AlongZ {
  static constexpr std::string_view kind = "planar";
  static constexpr std::string_view summary = "translates in a plane and rotates about its normal";
  static constexpr PlanarRole planar = PlanarRole::normal;
  static constexpr Quantity q_names[] = {{"s_x", "m", "displacement of M relative to F along F's x axis"},
                                         {"s_y", "m", "displacement of M relative to F along F's y axis"},
                                         {"phi", "rad", "angle of M relative to F about the normal (unwrapped)"}};
  static constexpr Quantity v_names[] = {{"v_x", "m/s", "velocity, der(s_x)"},
                                         {"v_y", "m/s", "velocity, der(s_y)"},
                                         {"w", "rad/s", "angular velocity, der(phi)"}};
  static constexpr Quantity a_names[] = {{"a_x", "m/s2", "acceleration, der(v_x)"},
                                         {"a_y", "m/s2", "acceleration, der(v_y)"},
                                         {"wd", "rad/s2", "angular acceleration, der(w)"}};
  static constexpr bool reverses_by_half_turn = false, constant_S = false;
  static constexpr int shifts_in_F = 2;
  static constexpr double flip[] = {1, -1, -1};  // signs of q and v after half a turn of F and M about x

  std::optional<IsotropicFriction<false>> translation;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&PlanarJoint::translation>(
        {.name = "friction.translation", .text = "dry friction in the plane, a force in any direction"})};
    return all;
  }
  std::optional<ElementFault> fault() const {
    return translation ? translation->fault("friction.translation") : std::nullopt;
  }
  std::vector<FrictionPart> friction_parts() const {
    if (!translation) return {};
    return {friction_part("friction.translation", 2, *translation)};
  }

  static PlanarJoint make(std::span<const Eigen::Vector3d>) { return {}; }

  template <class A, class T>
  typename A::Pose X_FM(const T* q) const {
    using std::cos;
    using std::sin;
    typename A::Pose X;
    if constexpr (A::planar) {
      X = {cos(q[2]), sin(q[2]), q[0], q[1]};
    } else {
      X.R = rotation_z(q[2]);
      X.p << q[0], q[1], T(0);
    }
    return X;
  }
  template <class A, class T>
  typename A::Motion V_FM(const T* q, const T* v) const {
    using std::cos;
    using std::sin;
    const T c = cos(q[2]);
    const T s = sin(q[2]);
    return motion<A>(v[2], c * v[0] + s * v[1], c * v[1] - s * v[0]);
  }
  template <class A, class T>
  typename A::Motion bias(const T* q, const T* v) const {
    using std::cos;
    using std::sin;
    const T c = cos(q[2]);
    const T s = sin(q[2]);
    return motion<A>(T(0), v[2] * (c * v[1] - s * v[0]), -v[2] * (c * v[0] + s * v[1]));
  }
  template <class A, class T>
  void project(const T* q, const typename A::Force& F, T* tau) const {
    using std::cos;
    using std::sin;
    T n, x, y;
    if constexpr (A::planar) {
      n = F.n, x = F.x, y = F.y;
    } else {
      n = F.n.z(), x = F.f.x(), y = F.f.y();
    }
    const T c = cos(q[2]);
    const T s = sin(q[2]);
    tau[0] = c * x - s * y;
    tau[1] = s * x + c * y;
    tau[2] = n;
  }
  template <class A, class T>
  typename A::Force wrench_from_tau(const T* q, const T* tau) const {
    return as_force<A>(V_FM<A>(q, tau));
  }
  template <class A, class T>
  void speeds(const T* q, const typename A::Motion& V, T* v) const {
    project<A>(q, as_force<A>(V), v);  // S^T S = 1
  }
  template <class A>
  void coordinates(const typename A::Pose& X_FM, typename A::Scalar* q) const {
    if constexpr (A::planar) {
      q[0] = X_FM.px;
      q[1] = X_FM.py;
    } else {
      q[0] = X_FM.p.x();
      q[1] = X_FM.p.y();
    }
    q[2] = angle_z<A>(X_FM);
  }
  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    if constexpr (A::planar) {
      return 0;
    } else {
      out[0] = rows::point<A>(X_FM, 2);
      return 1 + rows::parallel_z<A>(X_FM, out + 1);
    }
  }

 private:
  template <class A, class T>
  static typename A::Motion motion(const T& w, const T& x, const T& y) {
    typename A::Motion V;
    if constexpr (A::planar) {
      V = {w, x, y};
    } else {
      V.w.z() = w;
      V.v << x, y, T(0);
    }
    return V;
  }
};

}  // namespace gelenk
