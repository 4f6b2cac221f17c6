// SPDX-License-Identifier: BSD-3-Clause
// The derivative of the force on a body, f = G A + V x* G V, with respect to its velocity: df = 2 B dV if A changes by
// dV x V, with
//   2 B M = V x* (G M) - G (V x M) + M x* (G V)      (Echeandia & Wensing 2021; Singh, Russell & Wensing 2022).
// For rigid bodies most of B cancels: with M = (a | b), momentum p = m v - h x w and second moment I about the origin,
//   2 B M = (N a | -2 p x a),    N = [w]x (2 I - tr(I) 1) + 2 (h . v) 1 - 2 v h^T.
// N and p of several bodies, about the same point, can be added.
#pragma once

#include "math/planar.h"
#include "math/spatial.h"

namespace gelenk {

// The operator 2 B, in an algebra on doubles.
template <class A>
struct Coriolis;

template <>
struct Coriolis<Spatial> {
  static constexpr int angular = 3;
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
  Eigen::Vector3d p = Eigen::Vector3d::Zero();

  Coriolis() = default;
  // GV: the momentum G V.
  Coriolis(const Spatial::Inertia& G, const Spatial::Motion& V, const Spatial::Force& GV) : p(GV.f) {
    Eigen::Matrix3d K = 2 * G.I;
    K.diagonal().array() -= G.I.trace();
    for (int j = 0; j < 3; ++j) N.col(j) = V.w.cross(K.col(j)) - (2 * G.h[j]) * V.v;
    N.diagonal().array() += 2 * G.h.dot(V.v);
  }
  Coriolis& operator+=(const Coriolis& b) {
    N += b.N;
    p += b.p;
    return *this;
  }
  Spatial::Force operator*(const Spatial::Motion& M) const { return {N * M.w, (-2 * p).cross(M.w)}; }
  // x <- the `angular` numbers with x . a = S . 2 B (a | b) for all a, b.
  void transposed(const Spatial::Motion& S, double* x) const {
    Eigen::Map<Eigen::Vector3d>{x} = N.transpose() * S.w + 2 * p.cross(S.v);
  }
};

template <>
struct Coriolis<Planar> {
  static constexpr int angular = 1;
  double N = 0, px = 0, py = 0;

  Coriolis() = default;
  Coriolis(const Planar::Inertia& G, const Planar::Motion& V, const Planar::Force& GV)
      : N(2 * (G.hx * V.x + G.hy * V.y)), px(GV.x), py(GV.y) {}
  Coriolis& operator+=(const Coriolis& b) {
    N += b.N;
    px += b.px;
    py += b.py;
    return *this;
  }
  Planar::Force operator*(const Planar::Motion& M) const { return {N * M.w, -2 * py * M.w, 2 * px * M.w}; }
  void transposed(const Planar::Motion& S, double* x) const { x[0] = N * S.w + 2 * (px * S.y - py * S.x); }
};

}  // namespace gelenk
