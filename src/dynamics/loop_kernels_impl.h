// SPDX-License-Identifier: BSD-3-Clause
// Rows of the loops: position errors, Jacobian, rates and accelerations.
#pragma once

#include <algorithm>

#include "dynamics/kernels.h"
#include "dynamics/turning.h"
#include "dynamics/visit.h"
#include "math/dual.h"

namespace gelenk::kernels {
inline namespace detail {

// The frame at M's origin with F's axes.
template <class A>
typename A::Pose shift_to_M(const typename A::Pose& X_FM) {
  typename A::Pose shift;
  if constexpr (A::planar) {
    shift.px = X_FM.px;
    shift.py = X_FM.py;
  } else {
    shift.p = X_FM.p;
  }
  return shift;
}

template <class A>
typename A::Motion angular_part(const typename A::Motion& V) {
  if constexpr (A::planar) {
    return {V.w, 0, 0};
  } else {
    return {V.w, Vector3<typename A::Scalar>::Zero()};
  }
}

// X of a frame on the first link of the path, in the parent of the last.
template <class A>
typename A::Pose from_ancestor(const Workspace<A>& ws, const std::vector<int>& path, typename A::Pose X) {
  for (const int i : path) X = ws.X_PL[i] * X;
  return X;
}

// Writes the generalised force of F (on a link, in it) along the speeds from the link down its path. Returns the place
// behind.
template <class A>
double* transmit(const Model<A>& model, const Workspace<A>& ws, const std::vector<int>& path, typename A::Force F,
                 double sign, double* row) {
  for (const int& i : path) {
    const auto& link = model.links[i];
    for (int k = link.iv; k < link.iv + link.nv; ++k) *row++ = sign * along<A>(link.turns, ws.S[k], F);
    if (&i != &path.back()) F = ws.X_PL[i].to_parent(F);
  }
  return row;
}

// The rows of a cut that are kept.
template <class A>
void needed_rows(const typename Model<A>::Cut& cut, const typename A::Pose& X_FM, Row<A>* out) {
  Row<A> all[6];
  Row<A>* const to = cut.all_rows ? out : all;
  visit_joint<A>(cut.joint, [&](const auto& joint) { joint.template rows<A>(X_FM, to); });
  if (cut.all_rows) return;
  for (int i = 0; i < cut.rows; ++i) out[i] = all[cut.kept[i]];
}

// Likewise wdot . V_FM, added to bias.
template <class A>
void add_rows_bias(const typename Model<A>::Cut& cut, const typename A::Pose& X_FM, const typename A::Motion& V_FM,
                   typename A::Scalar* bias) {
  using T = typename A::Scalar;
  T all[6] = {T(0), T(0), T(0), T(0), T(0), T(0)};
  T* const to = cut.all_rows ? bias : all;
  visit_joint<A>(cut.joint, [&](const auto& joint) { joint.template rows_bias<A>(X_FM, V_FM, to); });
  if (cut.all_rows) return;
  for (int i = 0; i < cut.rows; ++i) bias[i] += all[cut.kept[i]];
}

template <class A>
typename A::Motion in_F(const typename Model<A>::Cut& cut, const typename A::Pose& X_FM,
                        const typename A::Motion& on_b) {
  return X_FM.to_parent(cut.X_BM.to_child(on_b));
}

// Velocities at a cut, about F's origin, in F: of link a, and of link b against it.
template <class A>
struct CutVelocity {
  typename A::Motion V_a, V;
};

template <class A>
CutVelocity<A> velocity_at(const typename Model<A>::Cut& cut, const Workspace<A>& ws, std::size_t c) {
  const typename A::Motion V_a = cut.X_AF.to_child(ws.V[cut.link_a]);
  return {V_a, in_F<A>(cut, ws.X_FM[c], ws.V[cut.link_b]) - V_a};
}

// See loop_velocities. A_of: accelerations by link. After ws.V_FM.
template <class A>
typename A::Motion relative_acceleration(const typename Model<A>::Cut& cut, const Workspace<A>& ws, std::size_t c,
                                         const CutVelocity<A>& at, const std::vector<typename A::Motion>& A_of) {
  using Motion = typename A::Motion;
  const typename A::Pose& X_FM = ws.X_FM[c];
  const Motion rate =
      in_F<A>(cut, X_FM, A_of[cut.link_b]) - cut.X_AF.to_child(A_of[cut.link_a]) - A::cross(at.V_a, at.V);
  const Motion turning = angular_part<A>(ws.V_FM[c]);
  return shift_to_M<A>(X_FM).to_child(rate) + A::cross(turning, ws.V_FM[c] - turning);
}

// The second time derivatives of the rows' errors, from ws.A_cut.
template <class A>
void row_accelerations(const typename Model<A>::Cut& cut, const Workspace<A>& ws, std::size_t c,
                       typename A::Scalar* rows) {
  if (cut.rows == 0) return;
  for (int r = cut.first_row; r < cut.first_row + cut.rows; ++r) rows[r] = A::dot(ws.A_cut[c], ws.row[r].w);
  add_rows_bias<A>(cut, ws.X_FM[c], ws.V_FM[c], &rows[cut.first_row]);
}

}  // namespace detail

template <class A>
void loop_positions(const Model<A>& model, Workspace<A>& ws) {
  for (std::size_t c = 0; c < model.cuts.size(); ++c) {
    const auto& cut = model.cuts[c];
    // From the nearest common ancestor, not from the root: a loop on a vehicle closes as exactly far away as at home.
    ws.X_FM[c] = from_ancestor<A>(ws, cut.path_a, cut.X_AF).inverse() * from_ancestor<A>(ws, cut.path_b, cut.X_BM);
    if (cut.rows == 0) continue;
    needed_rows<A>(cut, ws.X_FM[c], &ws.row[cut.first_row]);
    for (int r = cut.first_row; r < cut.first_row + cut.rows; ++r) ws.Phi[r] = ws.row[r].Phi;
  }
}

template <class A>
void loop_jacobian(const Model<A>& model, Workspace<A>& ws) {
  for (std::size_t c = 0; c < model.cuts.size(); ++c) {
    const auto& cut = model.cuts[c];
    const typename A::Pose shift = shift_to_M<A>(ws.X_FM[c]);
    for (int r = cut.first_row; r < cut.first_row + cut.rows; ++r) {
      const typename A::Force F_F = shift.to_parent(ws.row[r].w);  // about F's origin
      double* const then = transmit(model, ws, cut.path_a, cut.X_AF.to_parent(F_F), -1.0, ws.J.values(r));
      transmit(model, ws, cut.path_b, cut.X_BM.to_parent(ws.X_FM[c].to_child(F_F)), 1.0, then);
    }
  }
}

// With everything written in F and d/dt meaning componentwise in F: the relative velocity about F's origin is
// V = V_b - V_a, its rate A_b - A_a - V_a x V; moved to M's origin p: (w, pdot = v + w x p) and
// (wdot, pddot = vdot + wdot x p + w x pdot). Gravity, the same for both, cancels.
template <class A>
void loop_velocities(const Model<A>& model, Workspace<A>& ws) {
  for (std::size_t c = 0; c < model.cuts.size(); ++c) {
    const auto& cut = model.cuts[c];
    const CutVelocity<A> at = velocity_at(cut, ws, c);
    const typename A::Motion V_M = shift_to_M<A>(ws.X_FM[c]).to_child(at.V);
    ws.V_FM[c] = V_M;
    ws.A_cut[c] = relative_acceleration(cut, ws, c, at, ws.A_bias);
    row_accelerations(cut, ws, c, ws.gamma.data());
    for (int r = cut.first_row; r < cut.first_row + cut.rows; ++r) {
      ws.rate[r] = A::dot(V_M, ws.row[r].w);
      ws.gamma[r] = -ws.gamma[r];
    }
  }
}

template <class A>
void loop_accelerations(const Model<A>& model, Workspace<A>& ws, typename A::Scalar* rows) {
  for (std::size_t c = 0; c < model.cuts.size(); ++c) {
    const auto& cut = model.cuts[c];
    ws.A_cut[c] = relative_acceleration(cut, ws, c, velocity_at(cut, ws, c), ws.A_full);
    row_accelerations(cut, ws, c, rows);
  }
}

}  // namespace gelenk::kernels
