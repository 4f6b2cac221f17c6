// SPDX-License-Identifier: BSD-3-Clause
// Constraint equations of loops, and their forces. The equations of a cut depend on the links a and b only through the
// pose X of M in F, the velocity U = V_b - V_a and its rate in F, W = A_b - A_a - V_a x U. A displacement along
// velocity m of a link between b (a) and the nearest common ancestor, sigma = 1 (-1), changes these, as seen from F, by
//   dX = sigma S_m,   dU = sigma (S_m x V_b + P_m),   dW = sigma (S_m x A_b + P_m x V_b + Q_m) - V_a x dU,
// the velocity itself changes U by sigma S_m and W by sigma (R_m + S_m x (V_a + V_b)). Velocities inward of the
// ancestor have no effect.
#pragma once

#include "derivatives/recursive_loads_impl.h"

namespace gelenk {

template <class A>
void RecursiveJacobians<A>::cut_wrench(int c, const LinearizationPoint& at) {
  const auto& cut = model_.cuts[c];
  Force sum{};
  for (int r = cut.first_row; r < cut.first_row + cut.rows; ++r) sum += at.lambda[r] * ws_.row[r].w;
  add_interaction(cuts_[c], cut.link_a, cut.link_b, at_M(c).to_parent(sum));
}

template <class A>
void RecursiveJacobians<A>::cut_jacobians(int c, const LinearizationPoint& at, Jacobians& tangent) {
  using D = DualAlgebra;
  const auto& cut = model_.cuts[c];
  if (cut.rows == 0) return;
  const Body& a = body_[cut.link_a];
  const Body& b = body_[cut.link_b];
  LocalRows& rows = local_;
  rows.X = at_M(c);
  const Motion U = b.V - a.V;
  rows.V = rows.X.to_child(U);
  rows.W = rows.X.to_child(b.acc - a.acc - A::cross(a.V, U));
  visit_joint<D>(cut.joint, [&](const auto& joint) {
    rows.w_varies = joint.rows_turn;
    if (!rows.w_varies && !tangent.of_rows) return;
    Row<D> all[6];
    Dual bias_X[6], bias_V[6];
    const auto X = detail::seeded(ws_.X_FM[c]);
    joint.template rows<D>(X, all);
    if (rows.w_varies) {
      joint.template rows_bias<D>(X, detail::constant(rows.V), bias_X);
      joint.template rows_bias<D>(detail::constant(ws_.X_FM[c]), detail::seeded(rows.V), bias_V);
    }
    for (int i = 0; i < cut.rows; ++i) {
      const int k = cut.all_rows ? i : cut.kept[i];
      rows.Phi[i] = detail::gradient<A>(all[k].Phi);
      rows.bias_X[i] = detail::gradient<A>(bias_X[k]);
      rows.bias_V[i] = detail::gradient<A>(bias_V[k]);
      if (!rows.w_varies) continue;
      for (int d = 0; d < A::dimension; ++d) rows.w[i][d] = detail::derivatives_along(all[k].w, d);
    }
  });
  row_jacobians(c, rows, tangent);
  reaction_jacobians(c, rows, at, tangent);
}

// With w = (n, f) of the equation, and pdot, pddot of M's origin, about M's origin:
//   rate = n . w + f . pdot,   c = n . wdot + f . pddot + bias(X, V),   pddot = vdot + w x pdot,
// so the derivatives of c are (0 | f x wdot + (f x w) x w) by X, (pdot x f | f x w) by U, (n | f) by W, and more terms
// if the constraint wrench varies.
template <class A>
void RecursiveJacobians<A>::row_jacobians(int c, const LocalRows& at, Jacobians& tangent) {
  using detail::carried;
  using detail::turned;
  const auto& cut = model_.cuts[c];
  const Body& a = body_[cut.link_a];
  const Body& b = body_[cut.link_b];
  const int nv = model_.nv;
  const Motion acceleration = at.W + detail::as_motion(turned<A>(at.V, as_force<A>(at.V)));
  for (int i = 0; i < cut.rows; ++i) {
    const int row = cut.first_row + i;
    const Force& w = ws_.row[row].w;
    const Force turning = turned<A>(at.V, w);
    Force by_X = turned<A>(at.V, turning) - turned<A>(at.W, w);
    Force by_U = carried<A>(at.V, w) - turning;
    Force rate_X = Force{} - turning;
    if (at.w_varies) {
      by_X += at.bias_X[i] - turned<A>(at.V, at.bias_V[i]);
      by_U += at.bias_V[i];
      double of_c[A::dimension], of_rate[A::dimension];
      for (int d = 0; d < A::dimension; ++d) {
        of_c[d] = A::dot(acceleration, at.w[i][d]);
        of_rate[d] = A::dot(at.V, at.w[i][d]);
      }
      Force extra;
      pack(of_c, extra);
      by_X += extra;
      pack(of_rate, extra);
      rate_X += extra;
    }
    const Force g_W = at.X.to_parent(w);
    const Force g_U = at.X.to_parent(by_U);
    const Force on_dU = g_U + A::cross_force(a.V, g_W);
    const Force on_S = at.X.to_parent(by_X) + A::cross_force(b.acc, g_W) + A::cross_force(b.V, on_dU);
    const Force on_P = on_dU + A::cross_force(b.V, g_W);
    const Force on_S_v = g_U + A::cross_force(a.V + b.V, g_W);
    double* const c_q = tangent.c.row(row).data();
    const auto sum = [&](const std::vector<IndexRange>& path, double sign) {
      for (const IndexRange range : path) {
        S_.add_dots(on_S, sign, range, c_q);
        P_.add_dots(on_P, sign, range, c_q);
        Q_.add_dots(g_W, sign, range, c_q);
        S_.add_dots(on_S_v, sign, range, c_q + nv);
        R_.add_dots(g_W, sign, range, c_q + nv);
      }
    };
    sum(cuts_[c].ranges_a, -1);
    sum(cuts_[c].ranges_b, 1);
    if (!tangent.of_rows) continue;
    const Force on_S_rate = at.X.to_parent(rate_X) + A::cross_force(b.V, g_W);
    const Force on_S_Phi = at.X.to_parent(at.Phi[i]);
    const auto sum_rates = [&](const std::vector<IndexRange>& path, double sign) {
      for (const IndexRange range : path) {
        S_.add_dots(on_S_rate, sign, range, tangent.rate_q.row(row).data());
        P_.add_dots(g_W, sign, range, tangent.rate_q.row(row).data());
        S_.add_dots(on_S_Phi, sign, range, tangent.Phi_q.row(row).data());
      }
    };
    sum_rates(cuts_[c].ranges_a, -1);
    sum_rates(cuts_[c].ranges_b, 1);
  }
}

// The derivatives of the constraint force as seen from F: its torque changes with its point of application, and the
// wrenches with X.
template <class A>
void RecursiveJacobians<A>::reaction_jacobians(int c, const LocalRows& at, const LinearizationPoint& point,
                                               Jacobians& tangent) const {
  const auto& cut = model_.cuts[c];
  const double* const lambda = point.lambda + cut.first_row;
  const Force force = at.X.to_child(cuts_[c].force);
  const auto changes = [&](const Motion& S_0) -> Gradient {
    const Motion S = at.X.to_child(S_0);
    Force by_X = Force{} - detail::turned<A>(S, force);
    if (at.w_varies) {
      double extra[A::dimension] = {};
      for (int r = 0; r < cut.rows; ++r) {
        for (int d = 0; d < A::dimension; ++d) extra[d] += lambda[r] * A::dot(S, at.w[r][d]);
      }
      Force by_w;
      pack(extra, by_w);
      by_X += by_w;
    }
    return {at.X.to_parent(by_X), {}};
  };
  add_link_pair_terms<false>(cuts_[c], body_[cut.link_b].V, changes, tangent);
}

}  // namespace gelenk
