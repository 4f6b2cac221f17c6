// SPDX-License-Identifier: BSD-3-Clause
// Operations of the kernels at a link that skip the zeros of revolute joints, whose motion is a rotation about the
// link's z axis, S = (0 0 1 | 0 0 0).
#pragma once

#include "kinematics/model.h"

namespace gelenk::kernels::inline detail {

// S . F
template <class A>
typename A::Scalar along(bool revolute, const typename A::Motion& S, const typename A::Force& F) {
  if (!revolute) return A::dot(S, F);
  if constexpr (A::planar) {
    return F.n;
  } else {
    return F.n.z();
  }
}

// G S
template <class A>
typename A::Force times(bool revolute, const typename A::Inertia& G, const typename A::Motion& S) {
  if (!revolute) return G * S;
  if constexpr (A::planar) {
    return {G.I, -G.hy, G.hx};
  } else {
    return {G.I.col(2), {-G.h.y(), G.h.x(), typename A::Scalar(0)}};
  }
}
template <class A>
typename A::Force times(bool revolute, const typename A::ArticulatedInertia& G, const typename A::Motion& S) {
  if (!revolute) return G * S;
  if constexpr (A::planar) {
    return {G.nw, G.xw, G.yw};
  } else {
    return {G.I.col(2), G.H.row(2).transpose()};
  }
}

// V += S v, revolute joints only.
template <class A>
void add_turn(const typename A::Scalar& v, typename A::Motion& V) {
  if constexpr (A::planar) {
    V.w += v;
  } else {
    V.w.z() += v;
  }
}

// V += S v
template <class A>
void add_motion(bool revolute, const typename A::Scalar& v, const typename A::Motion& S, typename A::Motion& V) {
  if (revolute) {
    add_turn<A>(v, V);
  } else {
    V += v * S;
  }
}

// V x S v, revolute joints only.
template <class A>
typename A::Motion cross_turn(const typename A::Motion& V, const typename A::Scalar& v) {
  using T = typename A::Scalar;
  if constexpr (A::planar) {
    return {T(0), V.y * v, -(V.x * v)};
  } else {
    return {{V.w.y() * v, -(V.w.x() * v), T(0)}, {V.v.y() * v, -(V.v.x() * v), T(0)}};
  }
}

// X rotated by phi [rad] about its own z axis.
template <class A>
typename A::Pose turned(const typename A::Pose& X, const typename A::Scalar& phi) {
  using std::cos;
  using std::sin;
  const auto c = cos(phi);
  const auto s = sin(phi);
  if constexpr (A::planar) {
    return {X.c * c - X.s * s, X.s * c + X.c * s, X.px, X.py};
  } else {
    typename A::Pose out;
    out.R.col(0) = c * X.R.col(0) + s * X.R.col(1);
    out.R.col(1) = c * X.R.col(1) - s * X.R.col(0);
    out.R.col(2) = X.R.col(2);
    out.p = X.p;
    return out;
  }
}

}  // namespace gelenk::kernels::inline detail
