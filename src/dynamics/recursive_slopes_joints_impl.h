// SPDX-License-Identifier: BSD-3-Clause
// Joints whose motions change with their coordinates, or whose coordinates are other numbers than turns. Each is small,
// so numbers that carry derivatives do for it alone.
#pragma once

#include "dynamics/recursive_slopes_impl.h"

namespace gelenk {
namespace detail {

inline Planar::Motion values(const PlanarAlgebra<Dual>::Motion& V) { return {V.w.value(), V.x.value(), V.y.value()}; }
inline Planar::Motion slope(const PlanarAlgebra<Dual>::Motion& V, int k) {
  return {V.w.slope()[k], V.x.slope()[k], V.y.slope()[k]};
}
inline Eigen::Vector3d slope(const Vector3<Dual>& x, int k) {
  return {x[0].slope()[k], x[1].slope()[k], x[2].slope()[k]};
}
inline Spatial::Motion values(const SpatialAlgebra<Dual>::Motion& V) {
  const auto value = [](const Dual& x) { return x.value(); };
  return {V.w.unaryExpr(value), V.v.unaryExpr(value)};
}
inline Spatial::Motion slope(const SpatialAlgebra<Dual>::Motion& V, int k) { return {slope(V.w, k), slope(V.v, k)}; }
inline Planar::Force values(const PlanarAlgebra<Dual>::Force& F) { return {F.n.value(), F.x.value(), F.y.value()}; }
inline Spatial::Force values(const SpatialAlgebra<Dual>::Force& F) {
  const auto value = [](const Dual& x) { return x.value(); };
  return {F.n.unaryExpr(value), F.f.unaryExpr(value)};
}
inline Planar::Force slope(const PlanarAlgebra<Dual>::Force& F, int k) {
  return {F.n.slope()[k], F.x.slope()[k], F.y.slope()[k]};
}
inline Spatial::Force slope(const SpatialAlgebra<Dual>::Force& F, int k) { return {slope(F.n, k), slope(F.f, k)}; }

inline PlanarAlgebra<Dual>::Force constant(const Planar::Force& F) { return {Dual(F.n), Dual(F.x), Dual(F.y)}; }
inline SpatialAlgebra<Dual>::Force constant(const Spatial::Force& F) { return {F.n.cast<Dual>(), F.f.cast<Dual>()}; }

// Coordinates of a joint that carry their slopes by its turns, qdot = N v.
template <class Joint>
void by_turns(const Joint& joint, const double* q, Dual* out) {
  for (int j = 0; j < Joint::nq; ++j) out[j] = Dual(q[j]);
  for (int k = 0; k < Joint::nv; ++k) {
    double unit[Joint::nv > 0 ? Joint::nv : 1] = {};
    double dq[Joint::nq > 0 ? Joint::nq : 1];
    unit[k] = 1;
    joint.rate(q, unit, dq);
    for (int j = 0; j < Joint::nq; ++j) out[j].slope()[k] = dq[j];
  }
}

}  // namespace detail

template <class A>
void RecursiveSlopes<A>::add_turning(int i, const Point& at) {
  using D = Dually;
  const auto& link = model_.links[i];
  if (std::holds_alternative<Spherical>(link.joint)) return;  // S is constant
  Body& b = body_[i];
  const Motion V_p = body_[link.parent].V;
  visit_joint<D>(link.joint, [&](const auto& joint) {
    Dual q[8], fixed[8], v[6], moved[6], vdot[6];
    detail::by_turns(joint, at.q + link.iq, q);
    for (int j = 0; j < link.nq; ++j) fixed[j] = Dual(at.q[link.iq + j]);
    for (int k = 0; k < link.nv; ++k) {
      v[k] = moved[k] = Dual(at.v[link.iv + k]);
      vdot[k] = Dual(at.vdot[link.iv + k]);
      moved[k].slope()[k] = 1;
    }
    const auto V = joint.template V_FM<D>(q, v);
    const auto bias = joint.template bias<D>(q, v);
    const auto rate = joint.template V_FM<D>(q, vdot) + bias;
    const auto bias_v = joint.template bias<D>(fixed, moved);
    b.acc += b.X.to_parent(detail::values(bias));
    for (int k = 0; k < link.nv; ++k) {
      const Motion e = b.X.to_parent(detail::slope(V, k));
      const int s = link.iv + k;
      P_of_[s] += e;
      Q_of_[s] += A::cross(V_p + b.V, e) + b.X.to_parent(detail::slope(rate, k));
      R_of_[s] += b.X.to_parent(detail::slope(bias_v, k));
    }
  });
}

// The change of S^T F at fixed F.
template <class A>
void RecursiveSlopes<A>::add_projection(int i, const Point& at, Slopes& by) const {
  using D = Dually;
  const auto& link = model_.links[i];
  if (std::holds_alternative<Spherical>(link.joint)) return;
  const Body& b = body_[i];
  const auto F = detail::constant(b.X.to_child(b.f + b.against));
  visit_joint<D>(link.joint, [&](const auto& joint) {
    Dual q[8], tau[6];
    detail::by_turns(joint, at.q + link.iq, q);
    joint.template project<D>(q, F, tau);
    for (int t = 0; t < link.nv; ++t) {
      for (int k = 0; k < link.nv; ++k) by.r(link.iv + t, link.iv + k) += tau[t].slope()[k];
    }
  });
}

// From slopes by turns to those by the numbers in q, of which a quaternion's length turns nothing.
template <class A>
void RecursiveSlopes<A>::to_numbers(const Point& at, const Slopes& by, Slopes& out) const {
  using D = Dually;
  const Eigen::Index nv = model_.nv;
  out.r.rightCols(nv) = by.r.rightCols(nv);
  out.c.rightCols(nv) = by.c.rightCols(nv);
  for (std::size_t i = 1; i < model_.links.size(); ++i) {
    const auto& link = model_.links[i];
    visit_joint<D>(link.joint, [&](const auto& joint) {
      const double* q = at.q + link.iq;
      const double* v = at.v + link.iv;
      Dual q_D[8], v_D[8], moved[8], fixed[8], rate[8];
      double length2 = 0;  // of the quaternion, which stands last
      if (link.nq > link.nv) {
        for (int j = link.nq - 4; j < link.nq; ++j) length2 += q[j] * q[j];
      }
      for (int j = 0; j < link.nq; ++j) {
        double unit[8] = {};
        double turn[8] = {};
        unit[j] = 1;
        joint.unrate(q, unit, turn);
        for (int k = 0; k < link.nv; ++k) {
          if (turn[k] == 0) continue;
          const bool of_quaternion = link.nq > link.nv && k >= link.nv - 3;
          const double by_number = of_quaternion ? turn[k] / length2 : turn[k];
          const int to = link.iq + j;
          const int from = link.iv + k;
          out.r.col(to) += by_number * by.r.col(from);
          out.c.col(to) += by_number * by.c.col(from);
          if (!out.of_rows) continue;
          out.Phi_q.col(to) += by_number * by.Phi_q.col(from);
          out.rate_q.col(to) += by_number * by.rate_q.col(from);
        }
        q_D[j] = fixed[j] = Dual(q[j]);
        q_D[j].slope()[j] = 1;
      }
      for (int k = 0; k < link.nv; ++k) {
        v_D[k] = moved[k] = Dual(v[k]);
        moved[k].slope()[k] = 1;
      }
      joint.rate(q_D, v_D, rate);
      for (int j = 0; j < link.nq; ++j) {
        for (int k = 0; k < link.nq; ++k) out.qdot_q(link.iq + j, link.iq + k) = rate[j].slope()[k];
      }
      joint.rate(fixed, moved, rate);
      for (int j = 0; j < link.nq; ++j) {
        for (int k = 0; k < link.nv; ++k) out.qdot_v(link.iq + j, link.iv + k) = rate[j].slope()[k];
      }
    });
  }
}

}  // namespace gelenk
