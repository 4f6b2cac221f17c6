// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "joint/base.h"

namespace gelenk {

// Universal: M rotates about axis a, fixed in F, then about axis b, fixed in M. a = x, b = (cos beta, sin beta, 0).
//   X_FM = Rot_x(phi_a) Rot_b(phi_b)      V_FM = (w_a a_M + w_b b | 0),  a_M = Rot_b(-phi_b) x
//   q = (phi_a, phi_b) [rad], v = qdot.   Sdot v = -w_a w_b b x a_M.
// Besides the common origin, the constraint equations keep the angle between a and b equal to beta.
struct Universal : PlainJoint<2> {
  static constexpr int axes = 2;
  static constexpr std::string_view kind = "universal";
  static constexpr std::string_view summary = "rotates about two intersecting axes (Cardan joint)";
  static constexpr PlanarRole planar = PlanarRole::never;
  static constexpr Quantity q_names[] = {{"phi_a", "rad", "angle about the first axis, fixed in F (unwrapped)"},
                                         {"phi_b", "rad", "angle about the second axis, fixed in M (unwrapped)"}};
  static constexpr Quantity v_names[] = {{"w_a", "rad/s", "angular velocity, der(phi_a)"},
                                         {"w_b", "rad/s", "angular velocity, der(phi_b)"}};
  static constexpr Quantity a_names[] = {{"a_a", "rad/s2", "angular acceleration, der(w_a)"},
                                         {"a_b", "rad/s2", "angular acceleration, der(w_b)"}};
  static constexpr bool reverses_by_half_turn = false, constant_S = false, rows_turn = true;

  double cos_beta = 0;
  double sin_beta = 1;

  static Universal make(std::span<const Eigen::Vector3d> axes) {
    return {{}, axes[0].dot(axes[1]), axes[0].cross(axes[1]).norm()};
  }
  static Eigen::Matrix3d canonical(std::span<const Eigen::Vector3d> axes) {
    const Eigen::Vector3d z = axes[0].cross(axes[1]).normalized();
    Eigen::Matrix3d R;
    R << axes[0], z.cross(axes[0]), z;
    return R;
  }

  template <class A, class T>
  typename A::Pose X_FM(const T* q) const {
    using std::cos;
    using std::sin;
    typename A::Pose X;
    const T c = cos(q[0]);
    const T s = sin(q[0]);
    Matrix3<T> R_a;
    R_a << T(1), T(0), T(0), T(0), c, -s, T(0), s, c;
    X.R = R_a * about_b(q[1]);
    return X;
  }
  template <class A, class T>
  typename A::Motion V_FM(const T* q, const T* v) const {
    typename A::Motion V;
    V.w = v[0] * a_M(q) + v[1] * b<T>();
    return V;
  }
  template <class A, class T>
  typename A::Motion bias(const T* q, const T* v) const {
    typename A::Motion B;
    B.w = v[0] * v[1] * a_M(q).cross(b<T>());
    return B;
  }
  template <class A, class T>
  void project(const T* q, const typename A::Force& F, T* tau) const {
    tau[0] = a_M(q).dot(F.n);
    tau[1] = b<T>().dot(F.n);
  }
  template <class A, class T>
  typename A::Force wrench_from_tau(const T* q, const T* tau) const {
    T c[2];
    solve_gram(tau[0], tau[1], c);
    return {c[0] * a_M(q) + c[1] * b<T>(), Vector3<T>::Zero()};
  }
  template <class A, class T>
  void speeds(const T* q, const typename A::Motion& V, T* v) const {
    solve_gram(a_M(q).dot(V.w), b<T>().dot(V.w), v);
  }
  template <class A>
  void coordinates(const typename A::Pose& X_FM, typename A::Scalar* q) const {
    using std::atan2;
    using std::cos;
    using std::sin;
    using T = typename A::Scalar;
    const Vector3<T> b_F = X_FM.R * b<T>();
    q[0] = atan2(b_F.z(), b_F.y());
    // Rot_b rotates z, which is normal to b, towards b x z.
    const Vector3<T> z_F = X_FM.R.col(2);
    const Vector3<T> z(z_F.x(), cos(q[0]) * z_F.y() + sin(q[0]) * z_F.z(), cos(q[0]) * z_F.z() - sin(q[0]) * z_F.y());
    q[1] = atan2(sin_beta * z.x() - cos_beta * z.y(), z.z());
  }
  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    using std::atan2;
    using T = typename A::Scalar;
    const int n = rows::coincident<A>(X_FM, out);
    const Vector3<T> b_F = X_FM.R * b<T>();
    const Vector3<T> c = Vector3<T>::UnitX().cross(b_F);
    const T s = c.norm();
    out[n].w = {};
    out[n].w.n = s > T(0) ? Vector3<T>(c / s) : Vector3<T>(Vector3<T>::UnitZ());
    out[n].Phi = atan2(s, b_F.x()) - atan2(sin_beta, cos_beta);
    return n + 1;
  }
  template <class A, class T>
  void rows_bias(const typename A::Pose& X_FM, const typename A::Motion& V, T* bias) const {
    const Vector3<T> b_F = X_FM.R * b<T>();
    const Vector3<T> c = Vector3<T>::UnitX().cross(b_F);
    const T s = c.norm();
    if (!(s > T(0))) return;
    const T angle_rate = c.dot(V.w) / s;  // of the angle between a and b; zero if the velocity satisfies the constraint
    const Vector3<T> cdot = Vector3<T>::UnitX().cross(V.w.cross(b_F));
    bias[3] += (V.w.dot(cdot) - angle_rate * angle_rate * b_F.x()) / s;
  }

 private:
  // x with [1 cos; cos 1] x = (along_a, along_b): the Gram matrix of a and b.
  template <class T>
  void solve_gram(const T& along_a, const T& along_b, T* x) const {
    const double k = 1 / (sin_beta * sin_beta);
    x[0] = k * (along_a - cos_beta * along_b);
    x[1] = k * (along_b - cos_beta * along_a);
  }
  // Axis b, written in M.
  template <class T>
  Vector3<T> b() const {
    return {T(cos_beta), T(sin_beta), T(0)};
  }
  // Rot_b(phi).
  template <class T>
  Matrix3<T> about_b(const T& phi) const {
    using std::cos;
    using std::sin;
    const Matrix3<T> K = cross_matrix<T>(b<T>());
    return Matrix3<T>::Identity() + sin(phi) * K + (T(1) - cos(phi)) * (K * K);
  }
  // Axis a, written in M.
  template <class T>
  Vector3<T> a_M(const T* q) const {
    return about_b(q[1]).row(0).transpose();
  }
};

}  // namespace gelenk
