// SPDX-License-Identifier: BSD-3-Clause
// Forces between two links a and b that depend on their relative pose and velocity. As seen from a, the force L that b
// requires changes by K dX + D dU, with dX = sigma S_m, dU = sigma (S_m x V_b + P_m), sigma = 1 (-1) for velocities m
// between b (a) and the nearest common ancestor. With z_t = K^T S_t + V_b x* D^T S_t and y_t = S_t x* L
//   t on b's path: r_tm = S_m . (z_t + y_t, if m is not outward of t), -S_m . (z_t + y_t) for m on a's path;
//   t on a's path: r_tm = -S_m . z_t for m on b's,   S_m . (z_t + y_t, if m is outward of t) for m on a's;
// plus sigma_t sigma_m P_m . D^T S_t in both; with respect to v, sigma_t sigma_m S_m . D^T S_t.
#pragma once

#include <numbers>

#include "derivatives/recursive_joints_impl.h"
#include "kinematics/force_ports.h"
#include "kinematics/load_kernels_impl.h"
#include "kinematics/loop_kernels_impl.h"

namespace gelenk {
namespace detail {

// (0 | w x f): the change of F's force if it rotates with V = (w | v).
template <class A>
typename A::Force turned(const typename A::Motion& V, const typename A::Force& F) {
  if constexpr (A::planar) {
    return {0, -V.w * F.y, V.w * F.x};
  } else {
    return {Eigen::Vector3d::Zero(), V.w.cross(F.f)};
  }
}
// (v x f | 0): the rate of its torque about a fixed point if its point of application moves with v.
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

// The pose of M in F with derivatives: along rotations about M's origin, then translations of it, in F's axes.
inline PlanarAlgebra<Dual>::Pose seeded(const Planar::Pose& X) {
  PlanarAlgebra<Dual>::Pose out{Dual(X.c), Dual(X.s), Dual(X.px), Dual(X.py)};
  out.c.derivatives()[0] = -X.s;
  out.s.derivatives()[0] = X.c;
  out.px.derivatives()[1] = out.py.derivatives()[2] = 1;
  return out;
}
inline SpatialAlgebra<Dual>::Pose seeded(const Pose3& X) {
  SpatialAlgebra<Dual>::Pose out{X.R.cast<Dual>(), X.p.cast<Dual>()};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Eigen::Vector3d d_axis = Eigen::Vector3d::Unit(i).cross(X.R.col(j));
      for (int k = 0; k < 3; ++k) out.R(k, j).derivatives()[i] = d_axis[k];
    }
    out.p[i].derivatives()[3 + i] = 1;
  }
  return out;
}
// V_FM with derivatives along its components.
inline PlanarAlgebra<Dual>::Motion seeded(const Planar::Motion& V) {
  PlanarAlgebra<Dual>::Motion out{Dual(V.w), Dual(V.x), Dual(V.y)};
  out.w.derivatives()[0] = out.x.derivatives()[1] = out.y.derivatives()[2] = 1;
  return out;
}
inline SpatialAlgebra<Dual>::Motion seeded(const Spatial::Motion& V) {
  SpatialAlgebra<Dual>::Motion out{V.w.cast<Dual>(), V.v.cast<Dual>()};
  for (int i = 0; i < 3; ++i) out.w[i].derivatives()[i] = out.v[i].derivatives()[3 + i] = 1;
  return out;
}
inline PlanarAlgebra<Dual>::Motion constant(const Planar::Motion& V) { return {Dual(V.w), Dual(V.x), Dual(V.y)}; }
inline SpatialAlgebra<Dual>::Motion constant(const Spatial::Motion& V) { return {V.w.cast<Dual>(), V.v.cast<Dual>()}; }

inline PlanarAlgebra<Dual>::Pose constant(const Planar::Pose& X) {
  return {Dual(X.c), Dual(X.s), Dual(X.px), Dual(X.py)};
}
inline SpatialAlgebra<Dual>::Pose constant(const Pose3& X) { return {X.R.cast<Dual>(), X.p.cast<Dual>()}; }

// The derivatives of x along the directions of seeded(), as a force (dual to the motions).
template <class A>
typename A::Force gradient(const Dual& x) {
  typename A::Force F;
  pack(x.derivatives().data(), F);
  return F;
}

inline Eigen::Vector3d linear(const Spatial::Force& F) { return F.f; }
inline Eigen::Vector3d linear(const Planar::Force& F) { return {F.x, F.y, 0}; }
// The wrench about the origin of the force f at p and the torque n.
template <class A>
typename A::Force force_at(const Eigen::Vector3d& p, const Eigen::Vector3d& f,
                           const Eigen::Vector3d& n = Eigen::Vector3d::Zero()) {
  if constexpr (A::planar) {
    return {n.z() + p.x() * f.y() - p.y() * f.x(), f.x(), f.y()};
  } else {
    return {n + p.cross(f), f};
  }
}
// X without its translation.
template <class Pose>
Pose turn_only(Pose X) {
  if constexpr (requires { X.p; }) {
    X.p.setZero();
  } else {
    X.px = X.py = 0;
  }
  return X;
}

}  // namespace detail

template <class A>
void RecursiveJacobians<A>::add_interaction(LinkPair& of, int a, int b, const Force& force) {
  of.force = force;
  body_[b].f_interaction += force;
  body_[a].f_interaction -= force;
}

// F's axes at M's origin.
template <class A>
typename A::Pose RecursiveJacobians<A>::at_M(int c) const {
  const auto& cut = model_.cuts[c];
  return body_[cut.link_a].X * cut.X_AF * kernels::shift_to_M<A>(ws_.X_FM[c]);
}

template <class A>
template <bool damped, class Changes>
// NOLINTNEXTLINE(readability-function-cognitive-complexity): one term after the other
void RecursiveJacobians<A>::add_link_pair_terms(const LinkPair& of, const Motion& V_b, Changes changes,
                                                Jacobians& tangent) const {
  // NOLINTNEXTLINE(readability-function-cognitive-complexity)
  const auto of_links = [&](const std::vector<int>& links, const std::vector<IndexRange>& same,
                            const std::vector<IndexRange>& other, bool on_b) {
    for (const int i : links) {
      const auto& link = model_.links[i];
      const int outwards = link.iv + link.nv;
      for (int t = link.iv; t < outwards; ++t) {
        const Gradient change = changes(S_of_[t]);
        Force z = change.by_X;
        if constexpr (damped) z += A::cross_force(V_b, change.by_U);
        const Force both = z + A::cross_force(S_of_[t], of.force);
        double* const row = tangent.r.row(t).data();
        for (const IndexRange range : other) S_.add_dots(on_b ? both : z, -1, range, row);
        for (const IndexRange range : same) {
          S_.add_dots(on_b ? both : z, 1, {range.first, std::min(range.last, outwards)}, row);
          S_.add_dots(on_b ? z : both, 1, {std::max(range.first, outwards), range.last}, row);
        }
        if constexpr (!damped) continue;
        for (const auto& [ranges, sign] : {std::pair(&same, 1), std::pair(&other, -1)}) {
          for (const IndexRange range : *ranges) {
            P_.add_dots(change.by_U, sign, range, row);
            S_.add_dots(change.by_U, sign, range, row + model_.nv);
          }
        }
      }
    }
  };
  of_links(of.a, of.ranges_a, of.ranges_b, false);
  of_links(of.b, of.ranges_b, of.ranges_a, true);
}

template <class A>
void RecursiveJacobians<A>::set_loads(const LinearizationPoint& at, int inputs) {
  bool loaded = !forces_.empty();
  for (const JointLoads& on : loads_.cuts) loaded = loaded || !on.empty();
  if (loaded) u_.assign(at.u, at.u + inputs);
  set_forces(at);
  for (int c = 0; c < static_cast<int>(cuts_.size()); ++c) {
    if (loads_.cuts[c].empty()) continue;
    const auto& cut = model_.cuts[c];
    const Pose X = at_M(c);
    const Motion V = X.to_child(body_[cut.link_b].V - body_[cut.link_a].V);
    const auto F = cut_force(c, detail::constant(ws_.X_FM[c]), detail::constant(V), at);
    add_interaction(cut_loads_[c], cut.link_a, cut.link_b, Force{} - X.to_parent(detail::values(F)));
  }
}

template <class A>
void RecursiveJacobians<A>::load_jacobians(const LinearizationPoint& at, Jacobians& tangent, Jacobians& out) {
  forces_jacobians(at, tangent, out);
  for (int c = 0; c < static_cast<int>(cuts_.size()); ++c) {
    if (!loads_.cuts[c].empty()) cut_load_jacobians(c, at, tangent, out);
  }
}

// The derivatives of S . L, where L is the force required by the last port, f and n at its point p: with
// x = v + w x p, S = (w | v),
//   d(x . f + w . n) = (f x w) . dp + x . df + w . dn.
template <class A>
void RecursiveJacobians<A>::force_jacobians(const PortJacobians& K, const Attachment& last, const LinkPair& of,
                                            Jacobians& tangent) const {
  const Body& on = body_[last.link];
  const Eigen::Vector3d p = kernels::point<double>(on.X, last);
  const Eigen::Vector3d f = detail::linear(of.force);
  const auto changes = [&](const Motion& S) -> Gradient {
    const Eigen::Vector3d x = detail::velocity(S, p);
    const Eigen::Vector3d w = detail::angular(S);
    const Eigen::Vector3d by_p = f.cross(w) - K.f_p.transpose() * x;
    if (K.of_points) {
      return {detail::force_at<A>(p, by_p), detail::force_at<A>(p, Eigen::Vector3d(-K.f_v.transpose() * x))};
    }
    return {detail::force_at<A>(p, by_p - K.n_p.transpose() * w, -K.f_a.transpose() * x - K.n_a.transpose() * w),
            detail::force_at<A>(p, -K.f_v.transpose() * x - K.n_v.transpose() * w,
                                -K.f_w.transpose() * x - K.n_w.transpose() * w)};
  };
  if (K.damped) {
    add_link_pair_terms<true>(of, on.V, changes, tangent);
  } else {
    add_link_pair_terms<false>(of, on.V, changes, tangent);
  }
}

// F: derivative of the force on the last link with respect to the input.
template <class A>
void RecursiveJacobians<A>::add_input_derivative(const Force& F, const LinkPair& of, int input, Jacobians& out) const {
  for (const auto& [ranges, sign] : {std::pair(&of.ranges_a, 1), std::pair(&of.ranges_b, -1)}) {
    for (const IndexRange range : *ranges) {
      for (int t = range.first; t < range.last; ++t) out.r_u(t, input) += sign * A::dot(S_of_[t], F);
    }
  }
}

// The force of a cut joint's motors, springs and stops on M, at M's origin in F's axes. V: V_FM.
template <class A>
typename RecursiveJacobians<A>::DualAlgebra::Force RecursiveJacobians<A>::cut_force(
    int c, const typename DualAlgebra::Pose& X, const typename DualAlgebra::Motion& V,
    const LinearizationPoint& at) const {
  using D = DualAlgebra;
  const auto& cut = model_.cuts[c];
  const auto turn = detail::turn_only(X);
  Dual q[max_cut_nq], v[6];
  Dual tau[6];
  return visit_joint<D>(cut.joint, [&](const auto& joint) -> typename D::Force {
    for (int i = 0; i < cut.nq; ++i) q[i] = Dual(at.cut_reference[cut.iq + i]);
    joint.template coordinates<D>(X, q);
    for (int i = 0; i < cut.nq; ++i) {
      const double turns = (at.cut_reference[cut.iq + i] - q[i].value()) / (2 * std::numbers::pi);
      if (cut.is_angle[i]) q[i] += Dual(2 * std::numbers::pi * std::round(turns));
    }
    joint.template speeds<D>(q, turn.to_child(V), v);
    const int* sides = at.cut_sides;
    for (int before = 0; sides != nullptr && before < c; ++before) sides += loads_.cuts[before].switching_count();
    loads_.cuts[c].add(q, v, u_.data(), tau, sides);
    return turn.to_parent(joint.template wrench_from_tau<D>(q, tau));
  });
}

template <class A>
void RecursiveJacobians<A>::cut_load_jacobians(int c, const LinearizationPoint& at, Jacobians& tangent,
                                               Jacobians& out) {
  const auto& cut = model_.cuts[c];
  const Pose X = at_M(c);
  const Motion V_b = body_[cut.link_b].V;
  const Motion V = X.to_child(V_b - body_[cut.link_a].V);
  const auto by_X = cut_force(c, detail::seeded(ws_.X_FM[c]), detail::constant(V), at);
  const auto by_V = cut_force(c, detail::constant(ws_.X_FM[c]), detail::seeded(V), at);
  const Force force = X.to_child(cut_loads_[c].force);
  const auto changes = [&](const Motion& S_0) -> Gradient {
    const Motion S = X.to_child(S_0);
    double x[A::dimension], u[A::dimension];
    for (int d = 0; d < A::dimension; ++d) {
      x[d] = -A::dot(S, detail::derivatives_along(by_X, d));
      u[d] = -A::dot(S, detail::derivatives_along(by_V, d));
    }
    Force of_X, of_V;
    pack(x, of_X);
    pack(u, of_V);
    of_X -= detail::turned<A>(V, of_V) + detail::turned<A>(S, force);
    return {X.to_parent(of_X), X.to_parent(of_V)};
  };
  add_link_pair_terms<true>(cut_loads_[c], V_b, changes, tangent);
  if (out.of_inputs) cut_input_derivatives(c, at, out);
}

template <class A>
void RecursiveJacobians<A>::cut_input_derivatives(int c, const LinearizationPoint& at, Jacobians& out) {
  const auto& cut = model_.cuts[c];
  const Pose X = at_M(c);
  const auto V = detail::constant(X.to_child(body_[cut.link_b].V - body_[cut.link_a].V));
  each_list(loads_.cuts[c].lists, [&](const auto& list) {
    for (const auto& force : list) {
      for (int i = 0; i < force.input_count(); ++i) cut_input_derivative(c, force.input_at(i), V, at, out);
    }
  });
}

template <class A>
void RecursiveJacobians<A>::cut_input_derivative(int c, int input, const typename DualAlgebra::Motion& V,
                                                 const LinearizationPoint& at, Jacobians& out) {
  const Pose X = at_M(c);
  u_[input].derivatives()[0] = 1;
  const Force F = X.to_parent(detail::derivatives_along(cut_force(c, detail::constant(ws_.X_FM[c]), V, at), 0));
  u_[input].derivatives()[0] = 0;
  add_input_derivative(F, cut_loads_[c], input, out);
}

}  // namespace gelenk
