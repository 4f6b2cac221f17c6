// SPDX-License-Identifier: BSD-3-Clause
// The recursion along the tree.
#pragma once

#include "derivatives/recursive.h"
#include "kinematics/coordinate_derivatives.h"
#include "kinematics/load_kernels.h"
#include "kinematics/visit.h"
#include "math/dual.h"

namespace gelenk {
namespace detail {

inline void extend(std::vector<IndexRange>& ranges, int first, int last) {
  if (first == last) return;
  if (!ranges.empty() && ranges.back().last == first) {
    ranges.back().last = last;
  } else {
    ranges.push_back({first, last});
  }
}

// A unit rotation about the frame's z axis.
inline Spatial::Motion rotation_about_z(const Pose3& X) { return {X.R.col(2), X.p.cross(X.R.col(2))}; }
inline Planar::Motion rotation_about_z(const Planar::Pose& X) { return {1, X.py, -X.px}; }

// The velocities of the links on a path, which is listed from the outermost link inward.
template <class A>
std::vector<IndexRange> velocity_ranges(const Model<A>& model, const std::vector<int>& path) {
  std::vector<IndexRange> out;
  for (auto i = path.rbegin(); i != path.rend(); ++i) {
    const auto& link = model.links[*i];
    extend(out, link.iv, link.iv + link.nv);
  }
  return out;
}

// Links from i to the ground.
template <class A>
std::vector<int> path_to_ground(const Model<A>& model, int i) {
  std::vector<int> out;
  for (; i > 0; i = model.links[i].parent) out.push_back(i);
  return out;
}

}  // namespace detail

template <class A>
RecursiveJacobians<A>::RecursiveJacobians(const Model<A>& model, const Workspace<A>& ws, const Loads& loads)
    : model_(model),
      ws_(ws),
      loads_(loads),
      body_(model.links.size()),
      S_of_(model.nv),
      P_of_(model.nv),
      Q_of_(model.nv),
      R_of_(model.nv),
      S_(model.nv),
      P_(model.nv),
      Q_(model.nv),
      R_(model.nv),
      ranges_to_ground_(model.links.size()),
      has_quaternions_(model.nq != model.nv),
      column_q_(model.nv),
      column_v_(model.nv) {
  for (std::size_t i = 1; i < model.links.size(); ++i) {
    const auto& link = model.links[i];
    ranges_to_ground_[i] = ranges_to_ground_[link.parent];
    detail::extend(ranges_to_ground_[i], link.iv, link.iv + link.nv);
  }
  for (const auto& cut : model.cuts) cuts_.push_back(link_pair(cut.path_a, cut.path_b));
  cut_loads_ = cuts_;
  const auto between = [&](int a, int b) {
    std::vector<int> from_a = detail::path_to_ground(model, a);
    std::vector<int> from_b = detail::path_to_ground(model, b);
    for (; !from_a.empty() && !from_b.empty() && from_a.back() == from_b.back(); from_b.pop_back()) from_a.pop_back();
    return link_pair(from_a, from_b);
  };
  for (const auto [a, b] : links_of(*loads.forces)) forces_.push_back(between(a, b));
}

template <class A>
typename RecursiveJacobians<A>::LinkPair RecursiveJacobians<A>::link_pair(std::vector<int> a,
                                                                          std::vector<int> b) const {
  LinkPair out;
  out.ranges_a = detail::velocity_ranges(model_, a);
  out.ranges_b = detail::velocity_ranges(model_, b);
  out.a = std::move(a);
  out.b = std::move(b);
  return out;
}

template <class A>
void RecursiveJacobians<A>::operator()(const LinearizationPoint& at, int inputs, Jacobians& out) {
  out.clear(model_.nq, model_.nv, model_.rows, inputs, loads_.states());
  if (has_quaternions_) {
    tangent_.of_rows = out.of_rows;
    tangent_.clear(model_.nv, model_.nv, model_.rows, 0);
  }
  Jacobians& tangent = has_quaternions_ ? tangent_ : out;
  forward_pass(at);
  const int cuts = static_cast<int>(model_.cuts.size());
  for (int c = 0; c < cuts; ++c) cut_wrench(c, at);
  set_loads(at, inputs);
  backward_pass(at, tangent);
  for (int c = 0; c < cuts; ++c) cut_jacobians(c, at, tangent);
  load_jacobians(at, tangent, out);
  if (has_quaternions_) {
    to_coordinates(at, tangent, out);
  } else {
    out.qdot_v.setIdentity();
  }
  tree_load_jacobians(at, out);
  if (!out.of_rows) return;
  // Coordinate constraints are linear, and the directions of their forces constant.
  for (std::size_t i = 0; i < model_.coordinate_rows.size(); ++i) {
    const CoordinateRow& row = model_.coordinate_rows[i];
    if (!row.holds_position) continue;
    const auto r = model_.first_coordinate_row + static_cast<Eigen::Index>(i);
    for (const CoordinateRow::Term& term : row.terms) out.Phi_q(r, term.q) += term.factor;
  }
}

template <class A>
void RecursiveJacobians<A>::forward_pass(const LinearizationPoint& at) {
  const int n = static_cast<int>(model_.links.size());
  body_[0].V = {};
  body_[0].acc = kernels::root_acceleration<A>(loads_);
  body_[0].f_interaction = {};
  // Positions are relative to the inner joint frame of the first link.
  Pose& root = body_[0].X;
  if (n > 1) {
    if constexpr (A::planar) {
      root.px = -ws_.X_PL[1].px;
      root.py = -ws_.X_PL[1].py;
    } else {
      root.p = -ws_.X_PL[1].p;
    }
  }
  for (int i = 1; i < n; ++i) {
    const auto& link = model_.links[i];
    const Body& inner = body_[link.parent];
    Body& b = body_[i];
    b.X = inner.X * ws_.X_PL[i];
    Motion V_J{};
    for (int k = link.iv; k < link.iv + link.nv; ++k) {
      S_of_[k] = link.is_revolute_about_z ? detail::rotation_about_z(b.X) : b.X.to_parent(ws_.S[k]);
      V_J += at.v[k] * S_of_[k];
    }
    set_motion(i, at, V_J);
    b.G = link.G.moved_by(b.X);
    const Force momentum = b.G * b.V;
    b.B = Coriolis<A>(b.G, b.V, momentum);
    b.f = b.G * b.acc + A::cross_force(b.V, momentum);
    b.f_interaction = {};
  }
}

template <class A>
void RecursiveJacobians<A>::set_motion(int i, const LinearizationPoint& at, const Motion& V_J) {
  const auto& link = model_.links[i];
  const Body& inner = body_[link.parent];
  Body& b = body_[i];
  b.V = inner.V + V_J;
  b.acc = inner.acc + A::cross(inner.V, V_J);
  for (int k = link.iv; k < link.iv + link.nv; ++k) {
    const Motion& S = S_of_[k];
    b.acc += at.vdot[k] * S;
    P_of_[k] = A::cross(inner.V, S);
    Q_of_[k] = A::cross(inner.acc, S) + A::cross(inner.V, P_of_[k]);
    R_of_[k] = P_of_[k] + (link.nv == 1 ? P_of_[k] : A::cross(b.V, S));  // S x S = 0
  }
  if (!link.constant_subspace) add_variable_subspace(i, at);
  for (int k = link.iv; k < link.iv + link.nv; ++k) {
    S_.set(k, S_of_[k]);
    P_.set(k, P_of_[k]);
    Q_.set(k, Q_of_[k]);
    R_.set(k, R_of_[k]);
  }
}

template <class A>
void RecursiveJacobians<A>::backward_pass(const LinearizationPoint& at, Jacobians& tangent) {
  for (int i = static_cast<int>(model_.links.size()) - 1; i >= 1; --i) {
    const auto& link = model_.links[i];
    for (int k = link.iv; k < link.iv + link.nv; ++k) add_inertia_terms(i, k, tangent);
    if (!link.constant_subspace) add_projection(i, at, tangent);
    if (link.parent == 0) continue;
    const Body& b = body_[i];
    Body& inner = body_[link.parent];
    inner.G += b.G;
    inner.B += b.B;
    inner.f += b.f;
    inner.f_interaction += b.f_interaction;
  }
}

// Row k of r for the velocities inward and those of the link, and column k of r for the velocities inward:
//   r_kt = S_k . (2 B P_t + G Q_t),   r_tk = S_t . (2 B P_k + G Q_k + S_k x* f),
// for derivatives with respect to v with S and R instead of P and Q, and without f.
template <class A>
void RecursiveJacobians<A>::add_inertia_terms(int i, int k, Jacobians& tangent) {
  constexpr int n = A::dimension;
  constexpr int w = Coriolis<A>::angular;
  const Body& b = body_[i];
  double g[n], h[w], q[n], v[n];
  unpack(b.G * S_of_[k], g);
  b.B.transposed(S_of_[k], h);
  unpack(b.B * P_of_[k] + b.G * Q_of_[k] + A::cross_force(S_of_[k], b.f), q);
  unpack(b.B * S_of_[k] + b.G * R_of_[k], v);
  const int nv = model_.nv;
  const Eigen::Index width = tangent.r.cols();
  double* const r = tangent.r.data();
  const double* __restrict S = S_.component(0);
  const double* __restrict P = P_.component(0);
  const double* __restrict Q = Q_.component(0);
  const double* __restrict R = R_.component(0);
  double* __restrict row_q = r + k * width;
  double* __restrict row_v = row_q + nv;
  double* __restrict column_q = column_q_.data();
  double* __restrict column_v = column_v_.data();
  const int own = model_.links[i].iv;
  for (const IndexRange range : ranges_to_ground_[i]) {
    for (int t = range.first; t < range.last; ++t) {
      double a = 0;
      double c = 0;
      for (int j = 0; j < w; ++j) {
        a += h[j] * P[j * nv + t];
        c += h[j] * S[j * nv + t];
      }
      double d = 0;
      double e = 0;
      for (int j = 0; j < n; ++j) {
        a += g[j] * Q[j * nv + t];
        c += g[j] * R[j * nv + t];
        d += q[j] * S[j * nv + t];
        e += v[j] * S[j * nv + t];
      }
      row_q[t] = a;
      row_v[t] = c;
      column_q[t] = d;
      column_v[t] = e;
    }
    for (int t = range.first; t < std::min(range.last, own); ++t) {
      r[t * width + k] = column_q[t];
      r[t * width + nv + k] = column_v[t];
    }
  }
}

template <class A>
void RecursiveJacobians<A>::tree_load_jacobians(const LinearizationPoint& at, Jacobians& out) const {
  auto r_q = out.r_q();
  auto r_v = out.r_v();
  each_list(loads_.tree.lists, [&](const auto& list) {
    using E = std::decay_t<decltype(list.front().element)>;
    for (const auto& force : list) {
      if constexpr (HasJacobians<E>) {
        const auto [by_q, by_v] = force.element.jacobians(force.sign * at.q[force.q], force.sign * at.v[force.v]);
        r_q(force.v, force.q) -= by_q;
        r_v(force.v, force.v) -= by_v;
      } else {
        const int inputs = force.input_count();
        const DerivativesAlong derivatives = derivatives_by_duals(force, at.q, at.v, at.u, inputs);
        r_q(force.v, force.q) -= derivatives[0];
        r_v(force.v, force.v) -= derivatives[1];
        for (int i = 0; out.of_inputs && i < inputs; ++i)
          out.r_u(force.v, force.input_at(i)) -= derivatives[2 + static_cast<std::size_t>(i)];
      }
    }
  });
}

}  // namespace gelenk
