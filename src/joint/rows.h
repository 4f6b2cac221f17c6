// SPDX-License-Identifier: BSD-3-Clause
// Constraint equations of a joint that closes a loop, between its frames F and M.
//
// A constraint equation is given by a wrench w on M (torque about the origin of M, force), written in F. It does no
// work in the motions that the joint permits, w . V_FM = 0, so that it is both the row of the constraint Jacobian and
// the direction of the constraint force. V_FM is (angular velocity of M in F, rate of p_FM), both written in F. Phi is
// the position error [m or rad]; its rate is w . V_FM where Phi = 0.
#pragma once

#include <numbers>

#include "math/choose.h"
#include "math/planar.h"
#include "math/spatial.h"

namespace gelenk {

template <class A>
struct Row {
  typename A::Force w{};
  typename A::Scalar Phi{0};
};

namespace rows {

template <class A>
using Pose = typename A::Pose;

// Component i of p_FM, in F, is zero.
template <class A>
Row<A> point(const Pose<A>& X_FM, int i) {
  Row<A> row;
  if constexpr (A::planar) {
    (i == 0 ? row.w.x : row.w.y) = 1;
    row.Phi = i == 0 ? X_FM.px : X_FM.py;
  } else {
    row.w.f[i] = 1;
    row.Phi = X_FM.p[i];
  }
  return row;
}

// p_FM is zero. Returns the number of equations written.
template <class A>
int coincident(const Pose<A>& X_FM, Row<A>* out) {
  constexpr int n = A::planar ? 2 : 3;
  for (int i = 0; i < n; ++i) out[i] = point<A>(X_FM, i);
  return n;
}

// M does not rotate in F. The error is the rotation vector, which is zero at no other orientation and points along the
// axis of the shortest rotation, up to half a turn. Returns the number of equations written.
template <class A>
int no_turn(const Pose<A>& X_FM, Row<A>* out) {
  using std::atan2;
  if constexpr (A::planar) {
    out[0] = {{1, 0, 0}, atan2(X_FM.s, X_FM.c)};
    return 1;
  } else {
    const auto turn = rotation_vector(X_FM.R);
    for (int i = 0; i < 3; ++i) {
      out[i].w = {};
      out[i].w.n[i] = 1;
      out[i].Phi = turn[i];
    }
    return 3;
  }
}

// The z axes of F and M have the same direction; the error is the rotation vector from one to the other. Returns the
// number of equations written.
template <class A>
int parallel_z(const Pose<A>& X_FM, Row<A>* out) {
  if constexpr (A::planar) {
    return 0;
  } else {
    using std::atan2;
    using std::sqrt;
    using T = typename A::Scalar;
    const Vector3<T> z = X_FM.R.col(2);
    const T s = sqrt(z.x() * z.x() + z.y() * z.y());
    for (int i = 0; i < 2; ++i) {
      out[i].w = {};
      out[i].w.n[i] = 1;
    }
    // s = 0 with equal directions: x/sin(x) = 1. s = 0 with opposite directions: x is chosen as the axis.
    const T k = choose(s, [&] { return T(atan2(s, z.z()) / s); }, [] { return T(1); });
    const auto turn = [&] { return T(-k * z.y()); };
    out[0].Phi = choose(s, turn, [&] { return choose(z.z(), turn, [] { return T(std::numbers::pi); }); });
    out[1].Phi = k * z.x();
    return 2;
  }
}

}  // namespace rows
}  // namespace gelenk
