// SPDX-License-Identifier: BSD-3-Clause
// Rows of loops, and their forces. A cut's rows see the links a and b only by where M stands in F, X, by the velocity
// U = V_b - V_a and by its rate in F, W = A_b - A_a - V_a x U. A turn along speed m of a link between b (a) and the
// nearest common ancestor, sigma = 1 (-1), changes these, as seen from F, by
//   dX = sigma S_m,   dU = sigma (S_m x V_b + P_m),   dW = sigma (S_m x A_b + P_m x V_b + Q_m) - V_a x dU,
// the speed itself U by sigma S_m and W by sigma (R_m + S_m x (V_a + V_b)); inwards of the ancestor nothing.
#pragma once

#include "derivatives/recursive_loads_impl.h"

namespace gelenk {

template <class A>
void RecursiveJacobians<A>::cut_wrench(int c, const LinearizationPoint& at) {
  const auto& cut = model_.cuts[c];
  Force sum{};
  for (int r = cut.first_row; r < cut.first_row + cut.rows; ++r) sum += at.lambda[r] * ws_.row[r].w;
  need(cuts_[c], cut.link_a, cut.link_b, at_M(c).to_parent(sum));
}

template <class A>
void RecursiveJacobians<A>::cut_jacobians(int c, const LinearizationPoint& at, Jacobians& by) {
  using D = Dually;
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
    rows.moving = joint.rows_turn;
    if (!rows.moving && !by.of_rows) return;
    Row<D> all[6];
    Dual bias_X[6], bias_V[6];
    const auto X = detail::moving(ws_.X_FM[c]);
    joint.template rows<D>(X, all);
    if (rows.moving) {
      joint.template rows_bias<D>(X, detail::constant(rows.V), bias_X);
      joint.template rows_bias<D>(detail::constant(ws_.X_FM[c]), detail::moving(rows.V), bias_V);
    }
    for (int i = 0; i < cut.rows; ++i) {
      const int k = cut.all_rows ? i : cut.kept[i];
      rows.Phi[i] = detail::gradient<A>(all[k].Phi);
      rows.bias_X[i] = detail::gradient<A>(bias_X[k]);
      rows.bias_V[i] = detail::gradient<A>(bias_V[k]);
      if (!rows.moving) continue;
      for (int d = 0; d < A::dimension; ++d) rows.w[i][d] = detail::derivatives_along(all[k].w, d);
    }
  });
  row_jacobians(c, rows, by);
  reaction_jacobians(c, rows, at, by);
}

// With n, f of the row and pdot, pddot of M's origin, about M's origin:
//   rate = n . w + f . pdot,   c = n . wdot + f . pddot + bias(X, V),   pddot = vdot + w x pdot,
// so c's slopes are (0 | f x wdot + (f x w) x w) by X, (pdot x f | f x w) by U, w itself by W, and more where w turns.
template <class A>
void RecursiveJacobians<A>::row_jacobians(int c, const LocalRows& at, Jacobians& by) {
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
    if (at.moving) {
      by_X += at.bias_X[i] - turned<A>(at.V, at.bias_V[i]);
      by_U += at.bias_V[i];
      double of_c[A::dimension], of_rate[A::dimension];
      for (int d = 0; d < A::dimension; ++d) {
        of_c[d] = A::dot(acceleration, at.w[i][d]);
        of_rate[d] = A::dot(at.V, at.w[i][d]);
      }
      Force more;
      pack(of_c, more);
      by_X += more;
      pack(of_rate, more);
      rate_X += more;
    }
    const Force g_W = at.X.to_parent(w);
    const Force g_U = at.X.to_parent(by_U);
    const Force on_dU = g_U + A::cross_force(a.V, g_W);
    const Force on_S = at.X.to_parent(by_X) + A::cross_force(b.acc, g_W) + A::cross_force(b.V, on_dU);
    const Force on_P = on_dU + A::cross_force(b.V, g_W);
    const Force on_S_v = g_U + A::cross_force(a.V + b.V, g_W);
    double* const c_q = by.c.row(row).data();
    const auto sum = [&](const std::vector<Run>& path, double sign) {
      for (const Run run : path) {
        S_.add_dots(on_S, sign, run, c_q);
        P_.add_dots(on_P, sign, run, c_q);
        Q_.add_dots(g_W, sign, run, c_q);
        S_.add_dots(on_S_v, sign, run, c_q + nv);
        R_.add_dots(g_W, sign, run, c_q + nv);
      }
    };
    sum(cuts_[c].runs_a, -1);
    sum(cuts_[c].runs_b, 1);
    if (!by.of_rows) continue;
    const Force on_S_rate = at.X.to_parent(rate_X) + A::cross_force(b.V, g_W);
    const Force on_S_Phi = at.X.to_parent(at.Phi[i]);
    const auto sum_rates = [&](const std::vector<Run>& path, double sign) {
      for (const Run run : path) {
        S_.add_dots(on_S_rate, sign, run, by.rate_q.row(row).data());
        P_.add_dots(g_W, sign, run, by.rate_q.row(row).data());
        S_.add_dots(on_S_Phi, sign, run, by.Phi_q.row(row).data());
      }
    };
    sum_rates(cuts_[c].runs_a, -1);
    sum_rates(cuts_[c].runs_b, 1);
  }
}

// The rows' force changes, as seen from F, as its torque grows where it is carried along and as w turns.
template <class A>
void RecursiveJacobians<A>::reaction_jacobians(int c, const LocalRows& at, const LinearizationPoint& point,
                                               Jacobians& by) const {
  const auto& cut = model_.cuts[c];
  const double* const lambda = point.lambda + cut.first_row;
  const Force force = at.X.to_child(cuts_[c].needed);
  const auto changes = [&](const Motion& S_0) -> Change {
    const Motion S = at.X.to_child(S_0);
    Force by_X = Force{} - detail::turned<A>(S, force);
    if (at.moving) {
      double more[A::dimension] = {};
      for (int r = 0; r < cut.rows; ++r) {
        for (int d = 0; d < A::dimension; ++d) more[d] += lambda[r] * A::dot(S, at.w[r][d]);
      }
      Force by_w;
      pack(more, by_w);
      by_X += by_w;
    }
    return {at.X.to_parent(by_X), {}};
  };
  add_pair<false>(cuts_[c], body_[cut.link_b].V, changes, by);
}

}  // namespace gelenk
