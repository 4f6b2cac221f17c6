// SPDX-License-Identifier: BSD-3-Clause
// Conversion of poses, motions and forces of both algebras to and from Python: poses are 4x4 matrices, motions and
// forces 6-vectors (angular part first); planar quantities are converted to spatial ones, with the plane's normal
// along z.
#pragma once

#include <Eigen/Core>

#include "math/planar.h"
#include "math/spatial.h"

namespace gelenk {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector = Eigen::VectorXd;

inline Eigen::Matrix4d shown(const Spatial::Pose& X) {
  Eigen::Matrix4d out = Eigen::Matrix4d::Identity();
  out.topLeftCorner<3, 3>() = X.R;
  out.topRightCorner<3, 1>() = X.p;
  return out;
}
inline Eigen::Matrix4d shown(const Planar::Pose& X) {
  Eigen::Matrix4d out = Eigen::Matrix4d::Identity();
  out.topLeftCorner<2, 2>() << X.c, -X.s, X.s, X.c;
  out.topRightCorner<4, 1>().head<2>() << X.px, X.py;
  return out;
}
inline Vector6 shown(const Spatial::Motion& V) { return (Vector6() << V.w, V.v).finished(); }
inline Vector6 shown(const Planar::Motion& V) { return (Vector6() << 0, 0, V.w, V.x, V.y, 0).finished(); }
inline Vector6 shown(const Spatial::Force& F) { return (Vector6() << F.n, F.f).finished(); }
inline Vector6 shown(const Planar::Force& F) { return (Vector6() << 0, 0, F.n, F.x, F.y, 0).finished(); }

template <class A>
typename A::Pose pose(const Eigen::Matrix4d& X) {
  if constexpr (A::planar) {
    return {X(0, 0), X(1, 0), X(0, 3), X(1, 3)};
  } else {
    return {X.topLeftCorner<3, 3>(), X.topRightCorner<3, 1>()};
  }
}
// A Motion or Force of the algebra from a 6-vector.
template <class A, class Out>
Out pair_of(const Vector6& V) {
  if constexpr (A::planar) {
    return {V[2], V[3], V[4]};
  } else {
    return {V.head<3>(), V.tail<3>()};
  }
}

}  // namespace gelenk
