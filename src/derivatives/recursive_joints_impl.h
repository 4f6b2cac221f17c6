// SPDX-License-Identifier: BSD-3-Clause
// Joints whose motion space S varies in M, or whose coordinates are a quaternion. Such a joint alone is differentiated
// with dual numbers, at little cost.
#pragma once

#include "derivatives/recursive_impl.h"
#include "kinematics/force_ports.h"

namespace gelenk {
namespace detail {

inline Planar::Motion values(const PlanarAlgebra<Dual>::Motion& V) { return {V.w.value(), V.x.value(), V.y.value()}; }
inline Planar::Motion derivatives_along(const PlanarAlgebra<Dual>::Motion& V, int k) {
  return {V.w.derivatives()[k], V.x.derivatives()[k], V.y.derivatives()[k]};
}
inline Spatial::Motion values(const SpatialAlgebra<Dual>::Motion& V) {
  const auto value = [](const Dual& x) { return x.value(); };
  return {V.w.unaryExpr(value), V.v.unaryExpr(value)};
}
inline Spatial::Motion derivatives_along(const SpatialAlgebra<Dual>::Motion& V, int k) {
  return {derivatives_along(V.w, k), derivatives_along(V.v, k)};
}
inline Planar::Force values(const PlanarAlgebra<Dual>::Force& F) { return {F.n.value(), F.x.value(), F.y.value()}; }
inline Spatial::Force values(const SpatialAlgebra<Dual>::Force& F) {
  const auto value = [](const Dual& x) { return x.value(); };
  return {F.n.unaryExpr(value), F.f.unaryExpr(value)};
}
inline Planar::Force derivatives_along(const PlanarAlgebra<Dual>::Force& F, int k) {
  return {F.n.derivatives()[k], F.x.derivatives()[k], F.y.derivatives()[k]};
}
inline Spatial::Force derivatives_along(const SpatialAlgebra<Dual>::Force& F, int k) {
  return {derivatives_along(F.n, k), derivatives_along(F.f, k)};
}

inline PlanarAlgebra<Dual>::Force constant(const Planar::Force& F) { return {Dual(F.n), Dual(F.x), Dual(F.y)}; }
inline SpatialAlgebra<Dual>::Force constant(const Spatial::Force& F) { return {F.n.cast<Dual>(), F.f.cast<Dual>()}; }

// The coordinates of a joint with their derivatives along its velocities, qdot = N v.
template <class Joint>
void seeded_by_velocities(const Joint& joint, const double* q, Dual* out) {
  for (int j = 0; j < Joint::nq; ++j) out[j] = Dual(q[j]);
  for (int k = 0; k < Joint::nv; ++k) {
    double unit[Joint::nv > 0 ? Joint::nv : 1] = {};
    double dq[Joint::nq > 0 ? Joint::nq : 1];
    unit[k] = 1;
    joint.qdot_from_v(q, unit, dq);
    for (int j = 0; j < Joint::nq; ++j) out[j].derivatives()[k] = dq[j];
  }
}

inline bool constant_S(const TreeJoint& joint) {
  return std::visit([](const auto& j) { return j.constant_S; }, joint);
}
inline int shifts_in_F(const TreeJoint& joint) {
  return std::visit([](const auto& j) { return j.shifts_in_F; }, joint);
}

}  // namespace detail

// Translations S_k along axes fixed in F change, as seen from M, by -S_m x S_k with a rotation m.
template <class A>
void RecursiveJacobians<A>::add_shifts_along_axes_of_F(int i, int shifts, const LinearizationPoint& at) {
  const auto& link = model_.links[i];
  Body& b = body_[i];
  const int turns = link.iv + shifts;
  Motion V{}, acc{}, W{};
  for (int k = link.iv; k < turns; ++k) {
    V += at.v[k] * S_of_[k];
    acc += at.vdot[k] * S_of_[k];
  }
  for (int m = turns; m < link.iv + link.nv; ++m) W += at.v[m] * S_of_[m];
  b.acc += A::cross(V, W);
  for (int k = link.iv; k < turns; ++k) R_of_[k] += A::cross(S_of_[k], W);
  for (int m = turns; m < link.iv + link.nv; ++m) {
    const Motion e = A::cross(V, S_of_[m]);
    P_of_[m] += e;
    Q_of_[m] += A::cross(body_[link.parent].V + b.V, e) + A::cross(e, W) + A::cross(acc, S_of_[m]);
    R_of_[m] += e;
  }
}

template <class A>
void RecursiveJacobians<A>::add_variable_subspace(int i, const LinearizationPoint& at) {
  using D = DualAlgebra;
  const auto& link = model_.links[i];
  if (detail::constant_S(link.joint)) return;
  if (const int shifts = detail::shifts_in_F(link.joint)) return add_shifts_along_axes_of_F(i, shifts, at);
  Body& b = body_[i];
  const Motion V_p = body_[link.parent].V;
  visit_joint<D>(link.joint, [&](const auto& joint) {
    Dual q[8], fixed[8], v[6], dual[6], vdot[6];
    detail::seeded_by_velocities(joint, at.q + link.iq, q);
    for (int j = 0; j < link.nq; ++j) fixed[j] = Dual(at.q[link.iq + j]);
    for (int k = 0; k < link.nv; ++k) {
      v[k] = dual[k] = Dual(at.v[link.iv + k]);
      vdot[k] = Dual(at.vdot[link.iv + k]);
      dual[k].derivatives()[k] = 1;
    }
    const auto V = joint.template V_FM<D>(q, v);
    const auto bias = joint.template bias<D>(q, v);
    const auto rate = joint.template V_FM<D>(q, vdot) + bias;
    const auto bias_v = joint.template bias<D>(fixed, dual);
    b.acc += b.X.to_parent(detail::values(bias));
    for (int k = 0; k < link.nv; ++k) {
      const Motion e = b.X.to_parent(detail::derivatives_along(V, k));
      const int s = link.iv + k;
      P_of_[s] += e;
      Q_of_[s] += A::cross(V_p + b.V, e) + b.X.to_parent(detail::derivatives_along(rate, k));
      R_of_[s] += b.X.to_parent(detail::derivatives_along(bias_v, k));
    }
  });
}

// The derivatives of S^T F at constant F.
template <class A>
void RecursiveJacobians<A>::add_projection(int i, const LinearizationPoint& at, Jacobians& tangent) const {
  using D = DualAlgebra;
  const auto& link = model_.links[i];
  if (detail::constant_S(link.joint)) return;
  const Body& b = body_[i];
  if (const int shifts = detail::shifts_in_F(link.joint)) {
    for (int k = link.iv; k < link.iv + shifts; ++k) {
      for (int m = link.iv + shifts; m < link.iv + link.nv; ++m) {
        tangent.r(k, m) += A::dot(A::cross(S_of_[k], S_of_[m]), b.f + b.f_interaction);
      }
    }
    return;
  }
  const auto F = detail::constant(b.X.to_child(b.f + b.f_interaction));
  visit_joint<D>(link.joint, [&](const auto& joint) {
    Dual q[8], tau[6];
    detail::seeded_by_velocities(joint, at.q + link.iq, q);
    joint.template project<D>(q, F, tau);
    for (int t = 0; t < link.nv; ++t) {
      for (int k = 0; k < link.nv; ++k) tangent.r(link.iv + t, link.iv + k) += tau[t].derivatives()[k];
    }
  });
}

// Converts derivatives with respect to displacements (nv) to those with respect to q (nq). The norm of a quaternion has
// no effect on its rotation.
template <class A>
void RecursiveJacobians<A>::to_coordinates(const LinearizationPoint& at, const Jacobians& tangent,
                                           Jacobians& out) const {
  const Eigen::Index nv = model_.nv;
  out.r_v() = tangent.r.rightCols(nv);
  out.c_v() = tangent.c.rightCols(nv);
  const auto add = [&](double factor, int from, int to) {
    if (factor == 0) return;
    out.r.col(to) += factor * tangent.r.col(from);
    out.c.col(to) += factor * tangent.c.col(from);
    if (!out.of_rows) return;
    out.Phi_q.col(to) += factor * tangent.Phi_q.col(from);
    out.rate_q.col(to) += factor * tangent.rate_q.col(from);
  };
  for (std::size_t i = 1; i < model_.links.size(); ++i) {
    const auto& link = model_.links[i];
    const int simple_count = link.nq > link.nv ? link.nv - 3 : link.nv;  // coordinates outside the quaternion
    for (int k = 0; k < simple_count; ++k) {
      add(1, link.iv + k, link.iq + k);
      out.qdot_v(link.iq + k, link.iv + k) = 1;
    }
    if (simple_count == link.nv) continue;
    const double* const Q = at.q + link.iq + simple_count;
    const double length2 = Q[0] * Q[0] + Q[1] * Q[1] + Q[2] * Q[2] + Q[3] * Q[3];
    for (int j = 0; j < 4; ++j) {
      double unit[4] = {};
      double turn[3], rate[4];
      unit[j] = 1;
      quaternion::v_from_qdot(Q, unit, turn);
      for (int k = 0; k < 3; ++k) add(turn[k] / length2, link.iv + simple_count + k, link.iq + simple_count + j);
      quaternion::qdot_from_v(unit, at.v + link.iv + simple_count, rate);  // qdot is linear in Q
      for (int k = 0; k < 4; ++k) out.qdot_q(link.iq + simple_count + k, link.iq + simple_count + j) = rate[k];
    }
    for (int k = 0; k < 3; ++k) {
      double unit[3] = {};
      double rate[4];
      unit[k] = 1;
      quaternion::qdot_from_v(Q, unit, rate);
      for (int j = 0; j < 4; ++j) out.qdot_v(link.iq + simple_count + j, link.iv + simple_count + k) = rate[j];
    }
  }
}

}  // namespace gelenk
