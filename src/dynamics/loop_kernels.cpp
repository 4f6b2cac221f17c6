// SPDX-License-Identifier: BSD-3-Clause
// Rows of the loops: position errors, Jacobian, rates and accelerations.
#include <algorithm>

#include "dynamics/kernels.h"
#include "dynamics/visit.h"

namespace gelenk::kernels {
namespace {

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
    return {V.w, Eigen::Vector3d::Zero()};
  }
}

// X of a frame on the first link of the path, in the parent of the last.
template <class A>
typename A::Pose from_ancestor(const Workspace<A>& ws, const std::vector<int>& path, typename A::Pose X) {
  for (const int i : path) X = ws.X_PL[i] * X;
  return X;
}

// Adds the generalised force of F (on a link, in it) to row, from the link down its path.
template <class A>
void transmit(const Model<A>& model, const Workspace<A>& ws, const std::vector<int>& path, typename A::Force F,
              double sign, double* row) {
  for (const int i : path) {
    const auto& link = model.links[i];
    for (int k = link.iv; k < link.iv + link.nv; ++k) row[k] += sign * A::dot(ws.S[k], F);
    F = ws.X_PL[i].to_parent(F);
  }
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
                   double* bias) {
  double all[6] = {};
  double* const to = cut.all_rows ? bias : all;
  visit_joint<A>(cut.joint, [&](const auto& joint) { joint.template rows_bias<A>(X_FM, V_FM, to); });
  if (cut.all_rows) return;
  for (int i = 0; i < cut.rows; ++i) bias[i] += all[cut.kept[i]];
}

}  // namespace

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
  std::fill(ws.J.begin(), ws.J.end(), 0.0);
  for (std::size_t c = 0; c < model.cuts.size(); ++c) {
    const auto& cut = model.cuts[c];
    const typename A::Pose shift = shift_to_M<A>(ws.X_FM[c]);
    for (int r = cut.first_row; r < cut.first_row + cut.rows; ++r) {
      double* row = ws.J.data() + static_cast<std::size_t>(r) * model.nv;
      const typename A::Force F_F = shift.to_parent(ws.row[r].w);  // about F's origin
      transmit(model, ws, cut.path_a, cut.X_AF.to_parent(F_F), -1.0, row);
      transmit(model, ws, cut.path_b, cut.X_BM.to_parent(ws.X_FM[c].to_child(F_F)), 1.0, row);
    }
  }
}

// With everything written in F and d/dt meaning componentwise in F: the relative velocity about F's origin is
// V = V_b - V_a, its rate A_b - A_a - V_a x V; moved to M's origin p: (w, pdot = v + w x p) and
// (wdot, pddot = vdot + wdot x p + w x pdot). Gravity, the same for both, cancels.
template <class A>
void loop_velocities(const Model<A>& model, Workspace<A>& ws) {
  using Motion = typename A::Motion;
  for (std::size_t c = 0; c < model.cuts.size(); ++c) {
    const auto& cut = model.cuts[c];
    const auto in_F = [&](const Motion& on_b) { return ws.X_FM[c].to_parent(cut.X_BM.to_child(on_b)); };
    const Motion V_a = cut.X_AF.to_child(ws.V[cut.link_a]);
    const Motion V = in_F(ws.V[cut.link_b]) - V_a;
    const Motion A_rel = in_F(ws.A_bias[cut.link_b]) - cut.X_AF.to_child(ws.A_bias[cut.link_a]) - A::cross(V_a, V);
    const typename A::Pose shift = shift_to_M<A>(ws.X_FM[c]);
    const Motion V_M = shift.to_child(V);
    const Motion turning = angular_part<A>(V_M);
    ws.V_FM[c] = V_M;
    ws.A_cut[c] = shift.to_child(A_rel) + A::cross(turning, V_M - turning);
    for (int r = cut.first_row; r < cut.first_row + cut.rows; ++r) {
      ws.rate[r] = A::dot(V_M, ws.row[r].w);
      ws.gamma[r] = A::dot(ws.A_cut[c], ws.row[r].w);
    }
    if (cut.rows == 0) continue;
    add_rows_bias<A>(cut, ws.X_FM[c], V_M, &ws.gamma[cut.first_row]);
    for (int r = cut.first_row; r < cut.first_row + cut.rows; ++r) ws.gamma[r] = -ws.gamma[r];
  }
}

#define GELENK_INSTANTIATE(A)                                   \
  template void loop_positions(const Model<A>&, Workspace<A>&); \
  template void loop_jacobian(const Model<A>&, Workspace<A>&);  \
  template void loop_velocities(const Model<A>&, Workspace<A>&);
GELENK_INSTANTIATE(Planar)
GELENK_INSTANTIATE(Spatial)
#undef GELENK_INSTANTIATE

}  // namespace gelenk::kernels
