// SPDX-License-Identifier: BSD-3-Clause
// Orientation coordinates Q[1..4] of joints that rotate about any axis: the unit quaternion of R_FM, vector part first,
// scalar part Q[4], as in Modelica. The velocity is the angular velocity of M in F, written in M [rad/s].
#pragma once

#include <cmath>
#include <limits>
#include <type_traits>

#include "math/spatial.h"

namespace gelenk::quaternion {

// Rotation matrix of Q/|Q|: independent of the length of Q, which changes between two normalizations.
template <class T>
Matrix3<T> rotation(const T* Q) {
  const Vector3<T> u(Q[0], Q[1], Q[2]);
  const Matrix3<T> K = cross_matrix<T>(u);
  const T s = T(2) / (u.squaredNorm() + Q[3] * Q[3]);
  return Matrix3<T>::Identity() + (s * Q[3]) * K + s * (K * K);
}

// Qdot = 1/2 Q (w, 0).
template <class T>
void qdot_from_v(const T* Q, const T* w, T* Qdot) {
  const Vector3<T> u(Q[0], Q[1], Q[2]);
  const Vector3<T> w_M(w[0], w[1], w[2]);
  const Vector3<T> udot = T(0.5) * (Q[3] * w_M + u.cross(w_M));
  for (int i = 0; i < 3; ++i) Qdot[i] = udot[i];
  Qdot[3] = T(-0.5) * u.dot(w_M);
}

// w = 2 vec(conj(Q) Qdot), for unit Q.
template <class T>
void v_from_qdot(const T* Q, const T* Qdot, T* w) {
  const Vector3<T> u(Q[0], Q[1], Q[2]);
  const Vector3<T> udot(Qdot[0], Qdot[1], Qdot[2]);
  const Vector3<T> w_M = T(2) * (Q[3] * udot - Qdot[3] * u - u.cross(udot));
  for (int i = 0; i < 3; ++i) w[i] = w_M[i];
}

// Divides Q by its length, if that is not 1 within rounding: the entries of what is at rest would alternate.
template <class T>
void normalize(T* Q) {
  using std::sqrt;
  constexpr double rounding = 2 * std::numeric_limits<double>::epsilon();
  const T square = Q[0] * Q[0] + Q[1] * Q[1] + Q[2] * Q[2] + Q[3] * Q[3];
  if constexpr (std::is_same_v<T, double>) {
    if (std::abs(square - 1) <= rounding) return;
  }
  const T k = T(1) / sqrt(square);
  for (int i = 0; i < 4; ++i) Q[i] *= k;
}

// Replaces Q by the quaternion of R: of Q and -Q the one closer to the previous Q.
template <class T>
void from_rotation(const Matrix3<T>& R, T* Q) {
  const Eigen::Quaternion<T> found(R);
  const T cosine = Q[0] * found.x() + Q[1] * found.y() + Q[2] * found.z() + Q[3] * found.w();
  const T sign = cosine < T(0) ? T(-1) : T(1);
  Q[0] = sign * found.x();
  Q[1] = sign * found.y();
  Q[2] = sign * found.z();
  Q[3] = sign * found.w();
}

}  // namespace gelenk::quaternion
