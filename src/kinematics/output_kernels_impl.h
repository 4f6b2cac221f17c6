// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kinematics/output_kernels.h"

#include "kinematics/load_kernels_impl.h"
#include "kinematics/revolute_kernels.h"
#include "kinematics/visit.h"
#include "math/dual.h"

namespace gelenk::kernels {
inline namespace detail {

template <class A>
Vector3<typename A::Scalar> first_moment_in_root(const typename A::Pose& X, const typename A::Inertia& G) {
  if constexpr (A::planar) {
    return {G.m * X.px + X.c * G.hx - X.s * G.hy, G.m * X.py + X.s * G.hx + X.c * G.hy, typename A::Scalar(0)};
  } else {
    return G.m * X.p + X.R * G.h;
  }
}

// From the net force F on each link to the wrench in its joint: adds the constraint forces of cuts and sums inward.
template <class A>
void gather_wrenches(const Model<A>& model, const Workspace<A>& ws, const typename A::Scalar* lambda,
                     std::vector<typename A::Force>& F) {
  for (std::size_t c = 0; c < model.cuts.size(); ++c) {
    const auto& cut = model.cuts[c];
    // Motors and springs of cut joints are already in F_ext; only the constraint forces are missing.
    const typename A::Force F_M = row_wrench(model, ws, static_cast<int>(c), lambda);
    F[cut.link_b] -= cut.X_BM.to_parent(F_M);
    F[cut.link_a] += cut.X_AF.to_parent(ws.X_FM[c].to_parent(F_M));
  }
  for (std::size_t i = model.links.size() - 1; i >= 1; --i) {
    const int parent = model.links[i].parent;
    if (parent > 0) F[parent] += ws.X_PL[i].to_parent(F[i]);
  }
}

// The accelerations that vdot adds to those for vdot = 0, by link.
template <class A>
void add_accelerations(const Model<A>& model, const typename A::Scalar* vdot, const Workspace<A>& ws,
                       std::vector<typename A::Motion>& added) {
  added[0] = {};
  for (int i = 1; i < static_cast<int>(model.links.size()); ++i) {
    const auto& link = model.links[i];
    added[i] = ws.X_PL[i].to_child(added[link.parent]);
    for (int k = link.iv; k < link.iv + link.nv; ++k)
      add_motion<A>(link.is_revolute_about_z, vdot[k], ws.S[k], added[i]);
  }
}

}  // namespace detail

template <class A>
void accelerations(const Model<A>& model, const typename A::Scalar* vdot, Workspace<A>& ws) {
  const int n = static_cast<int>(model.links.size());
  // A_bias contains the velocity products of all joints inward; only the contributions of vdot are propagated.
  add_accelerations(model, vdot, ws, ws.A_full);
  for (int i = 0; i < n; ++i) ws.A_full[i] += ws.A_bias[i];
  ws.F[0] = {};
  for (int i = 1; i < n; ++i) {
    const auto& G = model.links[i].G;
    ws.F[i] = G * ws.A_full[i] + A::cross_force(ws.V[i], G * ws.V[i]) - ws.F_ext[i];
  }
  gather_wrenches(model, ws, ws.lambda.data(), ws.F);
}

template <class A>
void wrenches_of(const Model<A>& model, const Workspace<A>& ws, const typename A::Scalar* vdot,
                 const typename A::Scalar* lambda, bool alone, JointWrenches<A>& out) {
  const std::size_t n = model.links.size();
  out.accelerations.resize(n);
  out.F.resize(n);
  add_accelerations(model, vdot, ws, out.accelerations);
  out.F[0] = {};
  for (std::size_t i = 1; i < n; ++i) {
    const auto& G = model.links[i].G;
    if (alone) {
      out.F[i] = G * out.accelerations[i];
    } else {
      out.accelerations[i] += ws.A_bias[i];
      out.F[i] = G * out.accelerations[i] + A::cross_force(ws.V[i], G * ws.V[i]) - ws.F_ext[i];
    }
  }
  gather_wrenches(model, ws, lambda, out.F);
}

template <class A>
void constraint_wrenches(const Model<A>& model, Workspace<A>& ws) {
  for (auto& F : ws.F) F = {};
  for (auto& F : ws.F_cut) F = {};
  gather_wrenches(model, ws, ws.lambda.data(), ws.F);
}

template <class A>
typename A::Force cut_reaction(const Model<A>& model, const Workspace<A>& ws, int c) {
  return row_wrench(model, ws, c, ws.lambda.data()) + ws.F_cut[c];
}

template <class A>
typename A::Force row_wrench(const Model<A>& model, const Workspace<A>& ws, int c, const typename A::Scalar* lambda) {
  const auto& cut = model.cuts[c];
  typename A::Force F_F{};  // at M's origin, in F
  for (int r = cut.first_row; r < cut.first_row + cut.rows; ++r) F_F -= lambda[r] * ws.row[r].w;
  typename A::Pose turn = ws.X_FM[c];
  if constexpr (A::planar) {
    turn.px = turn.py = 0;
  } else {
    turn.p.setZero();
  }
  return turn.to_child(F_F);
}

// In M, the rate of V_FM: its rate in F about F's origin, moved to M, is also its rate in M, since V x V = 0.
template <class A>
void cut_accelerations(const typename Model<A>::Cut& cut, const Workspace<A>& ws, int c, const typename A::Scalar* q,
                       const typename A::Scalar* v, typename A::Scalar* a) {
  using Motion = typename A::Motion;
  const auto in_F = [&](const Motion& on_b) { return ws.X_FM[c].to_parent(cut.X_BM.to_child(on_b)); };
  const Motion V_a = cut.X_AF.to_child(ws.V[cut.link_a]);
  const Motion V = in_F(ws.V[cut.link_b]) - V_a;
  const Motion rate = in_F(ws.A_full[cut.link_b]) - cut.X_AF.to_child(ws.A_full[cut.link_a]) - A::cross(V_a, V);
  const Motion in_M = ws.X_FM[c].to_child(rate);
  visit_joint<A>(cut.joint,
                 [&](const auto& joint) { joint.template speeds<A>(q, in_M - joint.template bias<A>(q, v), a); });
}

template <class A>
EnergyOf<typename A::Scalar> energy(const Model<A>& model, const Loads& loads, const Workspace<A>& ws) {
  using T = typename A::Scalar;
  EnergyOf<T> sum;
  sum.potential = loads.potential_offset;
  for (std::size_t i = 1; i < model.links.size(); ++i) {
    const auto& G = model.links[i].G;
    sum.kinetic += A::dot(ws.V[i], G * ws.V[i]) / 2;
    sum.potential -= loads.gravity.cast<T>().dot(first_moment_in_root<A>(ws.X_0L[i], G));
  }
  sum.potential += force_energy(loads, ws);
  return sum;
}

}  // namespace gelenk::kernels
