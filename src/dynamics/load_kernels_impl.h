// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "dynamics/load_kernels.h"

#include <cmath>

#include "dynamics/visit.h"
#include "math/dual.h"

namespace gelenk::kernels {
inline namespace detail {

template <class T>
Vector3<T> cast(const Eigen::Vector3d& a) {
  return {T(a.x()), T(a.y()), T(a.z())};
}

template <class T>
Vector3<T> point(const typename SpatialAlgebra<T>::Pose& X, const Attachment& at) {
  return X.point(cast<T>(at.p));
}
template <class T>
Vector3<T> point(const typename PlanarAlgebra<T>::Pose& X, const Attachment& at) {
  return {X.px + X.c * T(at.p.x()) - X.s * T(at.p.y()), X.py + X.s * T(at.p.x()) + X.c * T(at.p.y()),
          T(at.height + at.p.z())};
}

template <class T>
Vector3<T> to_root(const typename SpatialAlgebra<T>::Pose& X, const Vector3<T>& a_L) {
  return X.R * a_L;
}
template <class T>
Vector3<T> to_root(const typename PlanarAlgebra<T>::Pose& X, const Vector3<T>& a_L) {
  return {X.c * a_L.x() - X.s * a_L.y(), X.s * a_L.x() + X.c * a_L.y(), a_L.z()};
}
template <class T>
Vector3<T> to_link(const typename SpatialAlgebra<T>::Pose& X, const Vector3<T>& a_0) {
  return X.R.transpose() * a_0;
}
template <class T>
Vector3<T> to_link(const typename PlanarAlgebra<T>::Pose& X, const Vector3<T>& a_0) {
  return {X.c * a_0.x() + X.s * a_0.y(), X.c * a_0.y() - X.s * a_0.x(), a_0.z()};
}

template <class T>
Vector3<T> point_velocity(const typename SpatialAlgebra<T>::Motion& V, const Attachment& at) {
  return V.v + V.w.cross(cast<T>(at.p));
}
template <class T>
Vector3<T> point_velocity(const typename PlanarAlgebra<T>::Motion& V, const Attachment& at) {
  return {V.x - V.w * T(at.p.y()), V.y + V.w * T(at.p.x()), T(0)};
}

// Force and torque at a point of a link, in the link's axes, about its origin.
template <class T>
void apply(const Attachment& at, const Vector3<T>& f, const Vector3<T>& n, typename SpatialAlgebra<T>::Force& F) {
  F.n += n + cast<T>(at.p).cross(f);
  F.f += f;
}
template <class T>
void apply(const Attachment& at, const Vector3<T>& f, const Vector3<T>& n, typename PlanarAlgebra<T>::Force& F) {
  F.n += n.z() + T(at.p.x()) * f.y() - T(at.p.y()) * f.x();
  F.x += f.x();
  F.y += f.y();
}

template <class A>
void spring_load(const PointSpring& spring, Workspace<A>& ws) {
  using T = typename A::Scalar;
  const auto& X_from = ws.X_0L[spring.from.link];
  const auto& X_to = ws.X_0L[spring.to.link];
  const Vector3<T> d = spring_span(spring, ws);
  const Vector3<T> none = Vector3<T>::Zero();
  const auto pull_by = [&](const Vector3<T>& pull) {  // on `from`
    apply<T>(spring.from, to_link<T>(X_from, pull), none, ws.F_ext[spring.from.link]);
    apply<T>(spring.to, to_link<T>(X_to, Vector3<T>(-pull)), none, ws.F_ext[spring.to.link]);
  };
  if (spring.is_linear()) return pull_by(T(spring.stiffness) * d);
  const T L = d.norm();
  if (L == T(0)) return;  // no direction: collapsed_spring() tells
  const Vector3<T> e = d / L;
  const Vector3<T> v_to = to_root<T>(X_to, point_velocity<T>(ws.V[spring.to.link], spring.to));
  const Vector3<T> v_from = to_root<T>(X_from, point_velocity<T>(ws.V[spring.from.link], spring.from));
  const T rate = e.dot(v_to - v_from);
  const T tension = T(spring.stiffness) * (L - T(spring.length)) + T(spring.damping) * rate;
  pull_by(tension * e);
}

template <class A>
void wrench_load(const Wrench& wrench, const typename A::Scalar* u, Workspace<A>& ws) {
  using T = typename A::Scalar;
  Vector3<T> f = cast<T>(wrench.force);
  Vector3<T> n = cast<T>(wrench.torque);
  if (wrench.input >= 0) {
    const T* in = u + wrench.input;
    const Matrix3<T> R = wrench.R_user.cast<T>();
    f += R * Vector3<T>(in[0], in[1], in[2]);
    n += R * Vector3<T>(in[3], in[4], in[5]);
  }
  const int link = wrench.at.link;
  if (!wrench.in_link) {
    f = to_link<T>(ws.X_0L[link], f);
    n = to_link<T>(ws.X_0L[link], n);
  }
  apply<T>(wrench.at, f, n, ws.F_ext[link]);
}

}  // namespace detail

template <class A>
Vector3<typename A::Scalar> spring_span(const PointSpring& spring, const Workspace<A>& ws) {
  using T = typename A::Scalar;
  return point<T>(ws.X_0L[spring.to.link], spring.to) - point<T>(ws.X_0L[spring.from.link], spring.from);
}

template <class A>
void link_loads(const Model<A>& model, const Loads& loads, const typename A::Scalar* u, Workspace<A>& ws) {
  for (std::size_t i = 0; i < model.links.size(); ++i) ws.F_ext[i] = {};
  for (const PointSpring& spring : loads.springs) spring_load(spring, ws);
  for (const Wrench& wrench : loads.wrenches) wrench_load(wrench, u, ws);
}

template <class A>
void counted_cut_coordinates(const typename Model<A>::Cut& cut, const typename A::Pose& X_FM, const double* reference,
                             typename A::Scalar* q) {
  using T = typename A::Scalar;
  for (int i = 0; i < cut.nq; ++i) q[i] = T(reference[i]);
  visit_joint<A>(cut.joint, [&](const auto& joint) { joint.template coordinates<A>(X_FM, q); });
  for (int i = 0; i < cut.nq; ++i) {
    if (cut.turns[i]) q[i] += T(2 * M_PI * std::round((reference[i] - value_of(q[i])) / (2 * M_PI)));
  }
}

template <class A>
void cut_speeds(const typename Model<A>::Cut& cut, const Workspace<A>& ws, int c, const typename A::Scalar* q,
                typename A::Scalar* v) {
  // V_FM is written in F at M's origin; joints want it in M.
  typename A::Pose turn = ws.X_FM[c];
  if constexpr (A::planar) {
    turn.px = turn.py = 0;
  } else {
    turn.p.setZero();
  }
  const typename A::Motion V_M = turn.to_child(ws.V_FM[c]);
  visit_joint<A>(cut.joint, [&](const auto& joint) { joint.template speeds<A>(q, V_M, v); });
}

template <class A>
void cut_loads(const Model<A>& model, const Loads& loads, const typename A::Scalar* u, const double* reference,
               Workspace<A>& ws) {
  using T = typename A::Scalar;
  for (int c = 0; c < static_cast<int>(model.cuts.size()); ++c) {
    ws.F_cut[c] = {};
    const JointLoads& on = loads.cuts[c];
    if (on.empty()) continue;
    const auto& cut = model.cuts[c];
    T q[max_cut_nq], v[6];
    counted_cut_coordinates<A>(cut, ws.X_FM[c], reference + cut.iq, q);
    cut_speeds<A>(cut, ws, c, q, v);
    T tau[6] = {T(0), T(0), T(0), T(0), T(0), T(0)};
    on.add(q, v, u, tau);
    const typename A::Force F_M = visit_joint<A>(
        cut.joint, [&](const auto& joint) -> typename A::Force { return joint.template effort<A>(q, tau); });
    ws.F_cut[c] = F_M;
    ws.F_ext[cut.link_b] += cut.X_BM.to_parent(F_M);
    ws.F_ext[cut.link_a] -= cut.X_AF.to_parent(ws.X_FM[c].to_parent(F_M));
  }
}

}  // namespace gelenk::kernels
