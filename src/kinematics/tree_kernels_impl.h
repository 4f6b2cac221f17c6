// SPDX-License-Identifier: BSD-3-Clause
// Recursions along the tree (Featherstone 2008: table 5.1 inverse dynamics, table 6.2 mass matrix).
#pragma once

#include <algorithm>

#include "kinematics/kernels.h"
#include "kinematics/revolute_kernels.h"
#include "kinematics/visit.h"
#include "math/dual.h"

namespace gelenk::kernels {

template <class A>
void positions(const Model<A>& model, const typename A::Scalar* q, Workspace<A>& ws) {
  using T = typename A::Scalar;
  const int n = static_cast<int>(model.links.size());
  for (int i = 1; i < n; ++i) {
    const auto& link = model.links[i];
    const T* q_i = q + link.iq;
    if (link.is_revolute_about_z) {
      ws.X_PL[i] = turned<A>(link.X_PJ, *q_i);
      continue;
    }
    visit_joint<A>(link.joint, [&](const auto& joint) {
      constexpr int nv = std::decay_t<decltype(joint)>::nv;
      ws.X_PL[i] = link.X_PJ * joint.template X_FM<A>(q_i);
      for (int k = 0; k < nv; ++k) {
        T unit[nv > 0 ? nv : 1] = {};
        unit[k] = T(1);
        ws.S[link.iv + k] = joint.template V_FM<A>(q_i, unit);
      }
    });
  }
}

template <class A>
void root_poses(const Model<A>& model, const std::vector<int>& links, Workspace<A>& ws) {
  for (const int i : links) ws.X_0L[i] = ws.X_0L[model.links[i].parent] * ws.X_PL[i];
}

template <class A>
void velocities(const Model<A>& model, const typename A::Scalar* q, const typename A::Scalar* v,
                const typename A::Motion& root_acceleration, Workspace<A>& ws) {
  using Motion = typename A::Motion;
  ws.A_bias[0] = root_acceleration;
  const int n = static_cast<int>(model.links.size());
  for (int i = 1; i < n; ++i) {
    const auto& link = model.links[i];
    if (link.is_revolute_about_z) {
      const auto& speed = v[link.iv];
      ws.V[i] = link.parent == 0 ? Motion{} : ws.X_PL[i].to_child(ws.V[link.parent]);
      add_turn<A>(speed, ws.V[i]);
      ws.A_bias[i] = ws.X_PL[i].to_child(ws.A_bias[link.parent]) + cross_turn<A>(ws.V[i], speed);
      continue;
    }
    Motion V_J{};
    for (int k = link.iv; k < link.iv + link.nv; ++k) V_J += v[k] * ws.S[k];
    ws.V[i] = ws.X_PL[i].to_child(ws.V[link.parent]) + V_J;
    ws.A_bias[i] = ws.X_PL[i].to_child(ws.A_bias[link.parent]) + A::cross(ws.V[i], V_J);
    if (link.constant_subspace) continue;
    ws.A_bias[i] += visit_joint<A>(
        link.joint, [&](const auto& joint) -> Motion { return joint.template bias<A>(q + link.iq, v + link.iv); });
  }
}

template <class A>
void inverse_dynamics_bias(const Model<A>& model, Workspace<A>& ws, double* tau) {
  const int n = static_cast<int>(model.links.size());
  for (int i = 1; i < n; ++i) {
    const auto& G = model.links[i].G;
    ws.F[i] = G * ws.A_bias[i] + A::cross_force(ws.V[i], G * ws.V[i]) - ws.F_ext[i];
  }
  for (int i = n - 1; i >= 1; --i) {
    const auto& link = model.links[i];
    for (int k = link.iv; k < link.iv + link.nv; ++k) tau[k] = along<A>(link.is_revolute_about_z, ws.S[k], ws.F[i]);
    if (link.parent > 0) ws.F[link.parent] += ws.X_PL[i].to_parent(ws.F[i]);
  }
}

template <class A, class Factor>
void mass_matrix(const Model<A>& model, Workspace<A>& ws, Factor& M) {
  const int n = static_cast<int>(model.links.size());
  for (int i = 1; i < n; ++i) ws.G_tree[i] = model.links[i].G;
  for (int i = n - 1; i >= 1; --i) {
    const auto& link = model.links[i];
    for (int k = link.iv; k < link.iv + link.nv; ++k) {
      auto* const row = M.row(k);
      int d = M.depth(k);
      typename A::Force F = times<A>(link.is_revolute_about_z, ws.G_tree[i], ws.S[k]);
      for (int j = k; j >= link.iv; --j) row[d--] = along<A>(link.is_revolute_about_z, ws.S[j], F);
      for (int outer = i, p = link.parent; p > 0; outer = p, p = model.links[p].parent) {
        F = ws.X_PL[outer].to_parent(F);
        const auto& inner = model.links[p];
        for (int j = inner.iv + inner.nv - 1; j >= inner.iv; --j)
          row[d--] = along<A>(inner.is_revolute_about_z, ws.S[j], F);
      }
    }
    if (link.parent > 0) ws.G_tree[link.parent] += ws.G_tree[i].moved_by(ws.X_PL[i]);
  }
}

}  // namespace gelenk::kernels
