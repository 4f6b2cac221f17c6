// SPDX-License-Identifier: BSD-3-Clause
// Constraint equations of the loops: position errors, Jacobian, rates and accelerations.
#pragma once

#include <algorithm>

#include "kinematics/kernels.h"
#include "kinematics/load_kernels.h"
#include "kinematics/revolute_kernels.h"
#include "kinematics/visit.h"
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

// X_FM, and the poses in F of the links of both paths. Composed via the nearest common ancestor, not via the root, so
// that the closure error of a loop on a vehicle does not grow with the vehicle's distance from the origin.
template <class A>
typename A::Pose pose_around(const typename Model<A>::Cut& cut, Workspace<A>& ws) {
  typename A::Pose* X_FL = ws.X_FL.data() + cut.first_path;
  typename A::Pose X = cut.X_AF.inverse();
  for (const int i : cut.path_a) {
    *X_FL++ = X;
    X = X * ws.X_PL[i].inverse();
  }
  X_FL += cut.path_b.size();
  for (auto i = cut.path_b.rbegin(); i != cut.path_b.rend(); ++i) *--X_FL = X = X * ws.X_PL[*i];
  return X * cut.X_BM;
}

// The motion S of a link's joint (unit velocity), expressed at M's origin in F.
template <class A>
typename A::Motion motion_of_M(bool revolute, const typename A::Pose& X_FL, const typename A::Motion& S,
                               const typename A::Pose& X_FM) {
  if (!revolute) return shift_to_M<A>(X_FM).to_child(X_FL.to_parent(S));
  if constexpr (A::planar) {
    return {1, X_FL.py - X_FM.py, X_FM.px - X_FL.px};
  } else {
    const Vector3<typename A::Scalar> axis = X_FL.R.col(2);
    return {axis, axis.cross(X_FM.p - X_FL.p)};
  }
}

// Writes the Jacobian entries of a cut for the joints along a path, starting with its first link. Returns the position
// after the last entry.
template <class A, class T>
T* path_columns(const Model<A>& model, const Workspace<A>& ws, std::size_t c, const std::vector<int>& path,
                const typename A::Pose* X_FL, double sign, int stride, T* column) {
  const auto& cut = model.cuts[c];
  for (const int i : path) {
    const auto& link = model.links[i];
    for (int k = link.iv; k < link.iv + link.nv; ++k, ++column) {
      const typename A::Motion V = motion_of_M<A>(link.is_revolute_about_z, *X_FL, ws.S[k], ws.X_FM[c]);
      // NOLINTNEXTLINE(bugprone-implicit-widening-of-multiplication-result): a small matrix
      for (int r = 0; r < cut.rows; ++r) column[r * stride] = sign * A::dot(V, ws.row[cut.first_row + r].w);
    }
    ++X_FL;
  }
  return column;
}

// The constraint equations of a cut that are kept (Cut::kept).
template <class A>
void kept_rows(const typename Model<A>::Cut& cut, const typename A::Pose& X_FM, Row<A>* out) {
  Row<A> all[6];
  Row<A>* const to = cut.all_rows ? out : all;
  visit_joint<A>(cut.joint, [&](const auto& joint) { joint.template rows<A>(X_FM, to); });
  if (cut.all_rows) return;
  for (int i = 0; i < cut.rows; ++i) out[i] = all[cut.kept[i]];
}

// Adds wdot . V_FM of these equations to bias.
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

// Velocities at a cut, about F's origin, in F: of link a (V_a), and of link b relative to it (V).
template <class A>
struct CutVelocity {
  typename A::Motion V_a, V;
};

template <class A>
CutVelocity<A> velocity_at(const typename Model<A>::Cut& cut, const Workspace<A>& ws, std::size_t c) {
  const typename A::Motion V_a = cut.X_AF.to_child(ws.V[cut.link_a]);
  return {V_a, in_F<A>(cut, ws.X_FM[c], ws.V[cut.link_b]) - V_a};
}

// Rate of V_FM at cut c, see loop_velocities. A_of: accelerations by link. Reads ws.V_FM.
template <class A>
typename A::Motion relative_acceleration(const typename Model<A>::Cut& cut, const Workspace<A>& ws, std::size_t c,
                                         const CutVelocity<A>& at, const std::vector<typename A::Motion>& A_of) {
  using Motion = typename A::Motion;
  const typename A::Pose& X_FM = ws.X_FM[c];
  const Motion rate =
      in_F<A>(cut, X_FM, A_of[cut.link_b]) - cut.X_AF.to_child(A_of[cut.link_a]) - A::cross(at.V_a, at.V);
  const Motion angular_rate = angular_part<A>(ws.V_FM[c]);
  return shift_to_M<A>(X_FM).to_child(rate) + A::cross(angular_rate, ws.V_FM[c] - angular_rate);
}

// The second time derivatives of the position errors, from ws.A_cut.
template <class A>
void row_accelerations(const typename Model<A>::Cut& cut, const Workspace<A>& ws, std::size_t c,
                       typename A::Scalar* rows) {
  if (cut.rows == 0) return;
  for (int r = cut.first_row; r < cut.first_row + cut.rows; ++r) rows[r] = A::dot(ws.A_cut[c], ws.row[r].w);
  add_rows_bias<A>(cut, ws.X_FM[c], ws.V_FM[c], &rows[cut.first_row]);
}

template <class A>
double* path_speeds(const Model<A>& model, const Workspace<A>& ws, int c, const std::vector<int>& path,
                    const typename A::Pose* X_FL, double sign, const double* q, double* columns) {
  const auto& cut = model.cuts[c];
  for (const int i : path) {
    const auto& link = model.links[i];
    for (int k = link.iv; k < link.iv + link.nv; ++k, columns += cut.nv) {
      const typename A::Motion V = sign * motion_of_M<A>(link.is_revolute_about_z, *X_FL, ws.S[k], ws.X_FM[c]);
      cut_speeds<A>(cut, ws.X_FM[c], V, q, columns);
    }
    ++X_FL;
  }
  return columns;
}

}  // namespace detail

template <class A>
void cut_speed_columns(const Model<A>& model, const Workspace<A>& ws, int c, const double* q, double* columns) {
  const auto& cut = model.cuts[c];
  const typename A::Pose* X_FL = ws.X_FL.data() + cut.first_path;
  columns = detail::path_speeds(model, ws, c, cut.path_a, X_FL, -1.0, q, columns);
  detail::path_speeds(model, ws, c, cut.path_b, X_FL + cut.path_a.size(), 1.0, q, columns);
}

template <class A>
void loop_positions(const Model<A>& model, Workspace<A>& ws) {
  for (std::size_t c = 0; c < model.cuts.size(); ++c) {
    const auto& cut = model.cuts[c];
    ws.X_FM[c] = pose_around<A>(cut, ws);
    if (cut.rows == 0) continue;
    kept_rows<A>(cut, ws.X_FM[c], &ws.row[cut.first_row]);
    for (int r = cut.first_row; r < cut.first_row + cut.rows; ++r) ws.Phi[r] = ws.row[r].Phi;
  }
}

template <class A, class Rows>
void loop_jacobian(const Model<A>& model, const Workspace<A>& ws, Rows& J) {
  for (std::size_t c = 0; c < model.cuts.size(); ++c) {
    const auto& cut = model.cuts[c];
    if (cut.rows == 0) continue;
    const typename A::Pose* X_FL = ws.X_FL.data() + cut.first_path;
    const int stride = J.entries(cut.first_row);
    auto* column = J.values(cut.first_row);
    column = path_columns(model, ws, c, cut.path_a, X_FL, -1.0, stride, column);
    path_columns(model, ws, c, cut.path_b, X_FL + cut.path_a.size(), 1.0, stride, column);
  }
}

// All vectors are written in F, and d/dt is componentwise in F: the relative velocity about F's origin is
// V = V_b - V_a, its rate A_b - A_a - V_a x V; shifted to M's origin p: (w, pdot = v + w x p) and
// (wdot, pddot = vdot + wdot x p + w x pdot). Gravity, equal for both, cancels.
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
