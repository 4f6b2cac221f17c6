// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kinematics/load_kernels.h"

#include <cmath>
#include <numbers>

#include "kinematics/visit.h"
#include "math/dual.h"

namespace gelenk::kernels {
inline namespace detail {

// The angle within half a turn of the reference; q: up to full turns.
template <class T>
T in_turn_of(double reference, const T& q) {
  return q + T(2 * std::numbers::pi * std::round((reference - value_of(q)) / (2 * std::numbers::pi)));
}

}  // namespace detail

template <class A>
void counted_cut_coordinates(const typename Model<A>::Cut& cut, const typename A::Pose& X_FM, const double* reference,
                             typename A::Scalar* q) {
  using T = typename A::Scalar;
  for (int i = 0; i < cut.nq; ++i) q[i] = T(reference[i]);
  visit_joint<A>(cut.joint, [&](const auto& joint) { joint.template coordinates<A>(X_FM, q); });
  for (int i = 0; i < cut.nq; ++i) {
    if (cut.is_angle[i]) q[i] = in_turn_of(reference[i], q[i]);
  }
}

template <class A>
void cut_speeds(const typename Model<A>::Cut& cut, const typename A::Pose& X_FM, const typename A::Motion& V_FM,
                const typename A::Scalar* q, typename A::Scalar* v) {
  typename A::Pose turn = X_FM;  // joints expect V_FM in M
  if constexpr (A::planar) {
    turn.px = turn.py = 0;
  } else {
    turn.p.setZero();
  }
  const typename A::Motion V_M = turn.to_child(V_FM);
  visit_joint<A>(cut.joint, [&](const auto& joint) { joint.template speeds<A>(q, V_M, v); });
}

template <class A>
CutMotion<A> counted_cut_motion(const Model<A>& model, const Workspace<A>& ws, int c, const double* reference) {
  const auto& cut = model.cuts[c];
  CutMotion<A> out;
  counted_cut_coordinates<A>(cut, ws.X_FM[c], reference + cut.iq, out.q.data());
  cut_speeds<A>(cut, ws.X_FM[c], ws.V_FM[c], out.q.data(), out.v.data());
  return out;
}

template <class A>
void cut_loads(const Model<A>& model, const Loads& loads, const typename A::Scalar* u, const double* reference,
               Workspace<A>& ws, const int* sides) {
  using T = typename A::Scalar;
  for (int c = 0; c < static_cast<int>(model.cuts.size()); ++c) {
    ws.F_cut[c] = {};
    const JointLoads& on = loads.cuts[c];
    if (on.empty()) continue;
    const auto& cut = model.cuts[c];
    const auto at = counted_cut_motion(model, ws, c, reference);
    T tau[6] = {T(0), T(0), T(0), T(0), T(0), T(0)};
    on.add(at.q.data(), at.v.data(), u, tau, sides);
    if (sides != nullptr) sides += on.switching_count();
    const typename A::Force F_M = visit_joint<A>(cut.joint, [&](const auto& joint) -> typename A::Force {
      return joint.template wrench_from_tau<A>(at.q.data(), tau);
    });
    ws.F_cut[c] = F_M;
    ws.F_ext[cut.link_b] += cut.X_BM.to_parent(F_M);
    ws.F_ext[cut.link_a] -= cut.X_AF.to_parent(ws.X_FM[c].to_parent(F_M));
  }
}

}  // namespace gelenk::kernels
