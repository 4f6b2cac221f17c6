// SPDX-License-Identifier: BSD-3-Clause
// Contacts that hold speeds, not positions: what closes a loop through the ground where a wheel rolls on it.
//
// Like joints that close loops (base.h), with no coordinates of their own. F is the plane, z its normal; M is on the
// body, z the wheel's axis, or the axis along which the edge does not slide. Rows without position error have Phi = 0.
#pragma once

#include <cmath>

#include "joint/base.h"

namespace gelenk {

// What the contacts share: nothing moves at them by coordinates.
struct NoCoordinates {
  static constexpr PlanarRole planar = PlanarRole::never;
  static constexpr bool rows_turn = true;

  template <class A, class T>
  typename A::Motion bias(const T*, const T*) const {
    return {};
  }
  template <class A, class T>
  typename A::Force effort(const T*, const T*) const {
    return {};
  }
  template <class A, class T>
  void speeds(const T*, const typename A::Motion&, T*) const {}
  template <class A>
  void coordinates(const typename A::Pose&, typename A::Scalar*) const {}
};

// A thin disc of this radius about z of M rolls on the plane without slip. With the axis a and the normal n,
// s = |a x n|, the disc's lowest point is c = p + r d with d = ((n . a) a - n)/s. Rows, each a force at c:
//   normal        w = n,              Phi = p_z - r s, whose rate it is: along the disc d is stationary
//   longitudinal  w = l = (a x n)/s   no Phi
//   lateral       w = n x l           no Phi
struct Rolling : NoCoordinates {
  static constexpr int row_count = 3;
  double radius = 0;  // m

  template <class T>
  struct Frame {
    Vector3<T> a, l, d;
    T s;
  };
  // Where the disc lies flat on the plane, s = 0, there is no lowest point.
  template <class T>
  static Frame<T> frame(const Matrix3<T>& R) {
    Frame<T> f;
    f.a = R.col(2);
    const Vector3<T> across(f.a.y(), -f.a.x(), T(0));  // a x n
    f.s = across.norm();
    f.l = across / f.s;
    f.d = Vector3<T>(f.a.z() * f.a.x(), f.a.z() * f.a.y(), f.a.z() * f.a.z() - T(1)) / f.s;
    return f;
  }

  // Too flat to tell where its lowest point is.
  static bool lies_flat(const Pose3& X_FM) { return std::hypot(X_FM.R(0, 2), X_FM.R(1, 2)) < 1e-4; }

  // In F.
  template <class T>
  Vector3<T> contact_point(const typename SpatialAlgebra<T>::Pose& X_FM) const {
    return X_FM.p + T(radius) * frame<T>(X_FM.R).d;
  }

  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    using T = typename A::Scalar;
    const Frame<T> f = frame<T>(X_FM.R);
    const Vector3<T> arm = T(radius) * f.d;
    const Vector3<T> directions[] = {{T(0), T(0), T(1)}, f.l, {-f.l.y(), f.l.x(), T(0)}};
    for (int i = 0; i < row_count; ++i) {
      out[i].w.f = directions[i];
      out[i].w.n = arm.cross(directions[i]);
      out[i].Phi = T(0);
    }
    out[0].Phi = X_FM.p.z() - T(radius) * f.s;
    return row_count;
  }

  template <class A, class T>
  void rows_bias(const typename A::Pose& X_FM, const typename A::Motion& V, T* bias) const {
    const Frame<T> f = frame<T>(X_FM.R);
    // l turns about n with the heading; d = a x l turns with it and tilts with a.
    const Vector3<T> adot = V.w.cross(f.a);
    const T heading = (f.a.x() * adot.y() - f.a.y() * adot.x()) / (f.s * f.s);
    const Vector3<T> t(-f.l.y(), f.l.x(), T(0));
    const Vector3<T> ldot = heading * t;
    const Vector3<T> tdot = -heading * f.l;
    const Vector3<T> ddot = adot.cross(f.l) + f.a.cross(ldot);
    const Vector3<T> d_V = T(radius) * V.w.cross(ddot);  // of the point of the disc that is lowest
    const Vector3<T> v_c = V.v + T(radius) * V.w.cross(f.d);
    bias[0] += d_V.z();
    bias[1] += f.l.dot(d_V) + ldot.dot(v_c);
    bias[2] += t.dot(d_V) + tdot.dot(v_c);
  }
};

// M's origin does not slide along z of M: w = a, no Phi.
struct KnifeEdge : NoCoordinates {
  static constexpr int row_count = 1;

  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    out[0].w.n.setZero();
    out[0].w.f = X_FM.R.col(2);
    out[0].Phi = 0;
    return row_count;
  }
  template <class A, class T>
  void rows_bias(const typename A::Pose& X_FM, const typename A::Motion& V, T* bias) const {
    const Vector3<T> a = X_FM.R.col(2);
    bias[0] += V.w.cross(a).dot(V.v);
  }
};

}  // namespace gelenk
