// SPDX-License-Identifier: BSD-3-Clause
// Rows of loops, and their forces. A cut's rows see the links a and b only by where M stands in F, X, by the velocity
// U = V_b - V_a and by its rate in F, W = A_b - A_a - V_a x U. A turn along speed m of a link between b (a) and the
// nearest common ancestor, sigma = 1 (-1), changes these, as seen from F, by
//   dX = sigma S_m,   dU = sigma (S_m x V_b + P_m),   dW = sigma (S_m x A_b + P_m x V_b + Q_m) - V_a x dU,
// the speed itself U by sigma S_m and W by sigma (R_m + S_m x (V_a + V_b)); inwards of the ancestor nothing.
#pragma once

#include "dynamics/loop_kernels_impl.h"
#include "dynamics/recursive_slopes_joints_impl.h"

namespace gelenk {
namespace detail {

template <class J>
constexpr bool wrenches_turn = std::is_same_v<J, Universal> || std::is_same_v<J, Rod> || std::is_same_v<J, Rolling> ||
                               std::is_same_v<J, KnifeEdge>;

// (0 | w x f): how F's force would turn.
template <class A>
typename A::Force turned(const typename A::Motion& V, const typename A::Force& F) {
  if constexpr (A::planar) {
    return {0, -V.w * F.y, V.w * F.x};
  } else {
    return {Eigen::Vector3d::Zero(), V.w.cross(F.f)};
  }
}
// (v x f | 0): how its torque about a point fixed in space grows as it is carried along.
template <class A>
typename A::Force carried(const typename A::Motion& V, const typename A::Force& F) {
  if constexpr (A::planar) {
    return {V.x * F.y - V.y * F.x, 0, 0};
  } else {
    return {V.v.cross(F.f), Eigen::Vector3d::Zero()};
  }
}
inline Planar::Motion as_motion(const Planar::Force& F) { return {F.n, F.x, F.y}; }
inline Spatial::Motion as_motion(const Spatial::Force& F) { return {F.n, F.f}; }

// M in F, moved along the directions 0 ...: turns about M's origin, then shifts of it, along F's axes.
inline PlanarAlgebra<Dual>::Pose moving(const Planar::Pose& X) {
  PlanarAlgebra<Dual>::Pose out{Dual(X.c), Dual(X.s), Dual(X.px), Dual(X.py)};
  out.c.slope()[0] = -X.s;
  out.s.slope()[0] = X.c;
  out.px.slope()[1] = out.py.slope()[2] = 1;
  return out;
}
inline SpatialAlgebra<Dual>::Pose moving(const Pose3& X) {
  SpatialAlgebra<Dual>::Pose out{X.R.cast<Dual>(), X.p.cast<Dual>()};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Eigen::Vector3d by = Eigen::Vector3d::Unit(i).cross(X.R.col(j));
      for (int k = 0; k < 3; ++k) out.R(k, j).slope()[i] = by[k];
    }
    out.p[i].slope()[3 + i] = 1;
  }
  return out;
}
// V_FM with its own components as directions.
inline PlanarAlgebra<Dual>::Motion moving(const Planar::Motion& V) {
  PlanarAlgebra<Dual>::Motion out{Dual(V.w), Dual(V.x), Dual(V.y)};
  out.w.slope()[0] = out.x.slope()[1] = out.y.slope()[2] = 1;
  return out;
}
inline SpatialAlgebra<Dual>::Motion moving(const Spatial::Motion& V) {
  SpatialAlgebra<Dual>::Motion out{V.w.cast<Dual>(), V.v.cast<Dual>()};
  for (int i = 0; i < 3; ++i) out.w[i].slope()[i] = out.v[i].slope()[3 + i] = 1;
  return out;
}
inline PlanarAlgebra<Dual>::Motion constant(const Planar::Motion& V) { return {Dual(V.w), Dual(V.x), Dual(V.y)}; }
inline SpatialAlgebra<Dual>::Motion constant(const Spatial::Motion& V) { return {V.w.cast<Dual>(), V.v.cast<Dual>()}; }

inline PlanarAlgebra<Dual>::Pose constant(const Planar::Pose& X) {
  return {Dual(X.c), Dual(X.s), Dual(X.px), Dual(X.py)};
}
inline SpatialAlgebra<Dual>::Pose constant(const Pose3& X) { return {X.R.cast<Dual>(), X.p.cast<Dual>()}; }

// The slopes of x by the directions of moving(), as a force that meets them.
template <class A>
typename A::Force gradient(const Dual& x) {
  typename A::Force F;
  pack(x.slope().data(), F);
  return F;
}

}  // namespace detail

template <class A>
void RecursiveSlopes<A>::cut_wrench(int c, const Point& at) {
  const auto& cut = model_.cuts[c];
  Force sum{};
  for (int r = cut.first_row; r < cut.first_row + cut.rows; ++r) sum += at.lambda[r] * ws_.row[r].w;
  Pose X = body_[cut.link_a].X * cut.X_AF;
  X = X * kernels::detail::shift_to_M<A>(ws_.X_FM[c]);
  wrench_[c] = X.to_parent(sum);
  body_[cut.link_b].of_rows += wrench_[c];
  body_[cut.link_a].of_rows -= wrench_[c];
}

template <class A>
void RecursiveSlopes<A>::cut_slopes(int c, const Point& at, Slopes& by) {
  using D = detail::DualOf<A>;
  const auto& cut = model_.cuts[c];
  if (cut.rows == 0) return;
  const Body& a = body_[cut.link_a];
  const Body& b = body_[cut.link_b];
  LocalRows& rows = local_;
  rows.X = a.X * cut.X_AF * kernels::detail::shift_to_M<A>(ws_.X_FM[c]);
  const Motion U = b.V - a.V;
  rows.V = rows.X.to_child(U);
  rows.W = rows.X.to_child(b.acc - a.acc - A::cross(a.V, U));
  visit_joint<D>(cut.joint, [&](const auto& joint) {
    rows.moving = detail::wrenches_turn<std::decay_t<decltype(joint)>>;
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
      for (int d = 0; d < A::dimension; ++d) rows.w[i][d] = detail::slope(all[k].w, d);
    }
  });
  row_slopes(c, rows, by);
  wrench_slopes(c, rows, at, by);
}

// With n, f of the row and pdot, pddot of M's origin, about M's origin:
//   rate = n . w + f . pdot,   c = n . wdot + f . pddot + bias(X, V),   pddot = vdot + w x pdot,
// so c's slopes are (0 | f x wdot + (f x w) x w) by X, (pdot x f | f x w) by U, w itself by W, and more where w turns.
template <class A>
void RecursiveSlopes<A>::row_slopes(int c, const LocalRows& at, Slopes& by) {
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
    sum(path_a_[c], -1);
    sum(path_b_[c], 1);
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
    sum_rates(path_a_[c], -1);
    sum_rates(path_b_[c], 1);
  }
}

// The rows' force L on b, -L on a, in r. It changes, as seen from F, by K dX; by what its torque grows as it is carried
// and by what w turns. With z_t = K^T S_t and y_t = S_t x* L,
//   t on b's path: r_tm = S_m . (z_t + y_t, if m is not outwards of t), -S_m . (z_t + y_t) for m on a's path;
//   t on a's path: r_tm = -S_m . z_t for m on b's,   S_m . (z_t + y_t, if m is outwards of t) for m on a's.
template <class A>
void RecursiveSlopes<A>::wrench_slopes(int c, const LocalRows& at, const Point& point, Slopes& by) {
  const auto& cut = model_.cuts[c];
  const Force& L = wrench_[c];
  const Force local = at.X.to_child(L);
  const double* const lambda = point.lambda + cut.first_row;
  const auto of_link = [&](int i, bool on_a) {
    const auto& link = model_.links[i];
    for (int t = link.iv; t < link.iv + link.nv; ++t) {
      const Motion S = at.X.to_child(S_of_[t]);
      Force z = Force{} - detail::turned<A>(S, local);
      if (at.moving) {
        double more[A::dimension] = {};
        for (int r = 0; r < cut.rows; ++r) {
          for (int d = 0; d < A::dimension; ++d) more[d] += lambda[r] * A::dot(S, at.w[r][d]);
        }
        Force by_w;
        pack(more, by_w);
        z += by_w;
      }
      z = at.X.to_parent(z);
      const Force both = z + A::cross_force(S_of_[t], L);
      double* const row = by.r.row(t).data();
      const int outwards = link.iv + link.nv;
      if (on_a) {
        for (const Run run : path_b_[c]) S_.add_dots(z, -1, run, row);
        for (const Run run : path_a_[c]) {
          S_.add_dots(z, 1, {run.first, std::min(run.last, outwards)}, row);
          S_.add_dots(both, 1, {std::max(run.first, outwards), run.last}, row);
        }
      } else {
        for (const Run run : path_a_[c]) S_.add_dots(both, -1, run, row);
        for (const Run run : path_b_[c]) {
          S_.add_dots(both, 1, {run.first, std::min(run.last, outwards)}, row);
          S_.add_dots(z, 1, {std::max(run.first, outwards), run.last}, row);
        }
      }
    }
  };
  for (const int i : cut.path_a) of_link(i, true);
  for (const int i : cut.path_b) of_link(i, false);
}

}  // namespace gelenk
