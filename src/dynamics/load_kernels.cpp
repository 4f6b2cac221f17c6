// SPDX-License-Identifier: BSD-3-Clause
#include "dynamics/load_kernels.h"

#include <cmath>

#include "dynamics/visit.h"

namespace gelenk::kernels {
namespace {

using Eigen::Vector3d;

Vector3d point(const Spatial::Pose& X, const Attachment& at) { return X.point(at.p); }
Vector3d point(const Planar::Pose& X, const Attachment& at) {
  return {X.px + X.c * at.p.x() - X.s * at.p.y(), X.py + X.s * at.p.x() + X.c * at.p.y(), at.height + at.p.z()};
}

Vector3d to_root(const Spatial::Pose& X, const Vector3d& a_L) { return X.R * a_L; }
Vector3d to_root(const Planar::Pose& X, const Vector3d& a_L) {
  return {X.c * a_L.x() - X.s * a_L.y(), X.s * a_L.x() + X.c * a_L.y(), a_L.z()};
}
Vector3d to_link(const Spatial::Pose& X, const Vector3d& a_0) { return X.R.transpose() * a_0; }
Vector3d to_link(const Planar::Pose& X, const Vector3d& a_0) {
  return {X.c * a_0.x() + X.s * a_0.y(), X.c * a_0.y() - X.s * a_0.x(), a_0.z()};
}

Vector3d point_velocity(const Spatial::Motion& V, const Attachment& at) { return V.v + V.w.cross(at.p); }
Vector3d point_velocity(const Planar::Motion& V, const Attachment& at) {
  return {V.x - V.w * at.p.y(), V.y + V.w * at.p.x(), 0};
}

// Force and torque at a point of a link, in the link's axes, about its origin.
void apply(const Attachment& at, const Vector3d& f, const Vector3d& n, Spatial::Force& F) {
  F += Spatial::Force{n + at.p.cross(f), f};
}
void apply(const Attachment& at, const Vector3d& f, const Vector3d& n, Planar::Force& F) {
  F += Planar::Force{n.z() + at.p.x() * f.y() - at.p.y() * f.x(), f.x(), f.y()};
}

template <class A>
void spring_load(const PointSpring& spring, Workspace<A>& ws) {
  const auto& X_from = ws.X_0L[spring.from.link];
  const auto& X_to = ws.X_0L[spring.to.link];
  const Vector3d d = spring_span(spring, ws);
  const double L = d.norm();
  if (L == 0) return;  // no direction; without free length no force either
  const Vector3d e = d / L;
  const double rate = e.dot(to_root(X_to, point_velocity(ws.V[spring.to.link], spring.to)) -
                            to_root(X_from, point_velocity(ws.V[spring.from.link], spring.from)));
  const Vector3d pull = (spring.stiffness * (L - spring.length) + spring.damping * rate) * e;  // on `from`
  apply(spring.from, to_link(X_from, pull), Vector3d::Zero(), ws.F_ext[spring.from.link]);
  apply(spring.to, to_link(X_to, -pull), Vector3d::Zero(), ws.F_ext[spring.to.link]);
}

template <class A>
void wrench_load(const Wrench& wrench, const double* u, Workspace<A>& ws) {
  Vector3d f = wrench.force;
  Vector3d n = wrench.torque;
  if (wrench.input >= 0) {
    const double* in = u + wrench.input;
    f += wrench.R_user * Vector3d(in[0], in[1], in[2]);
    n += wrench.R_user * Vector3d(in[3], in[4], in[5]);
  }
  const int link = wrench.at.link;
  if (!wrench.in_link) {
    f = to_link(ws.X_0L[link], f);
    n = to_link(ws.X_0L[link], n);
  }
  apply(wrench.at, f, n, ws.F_ext[link]);
}

}  // namespace

template <class A>
Vector3d spring_span(const PointSpring& spring, const Workspace<A>& ws) {
  return point(ws.X_0L[spring.to.link], spring.to) - point(ws.X_0L[spring.from.link], spring.from);
}

template <class A>
void link_loads(const Model<A>& model, const Loads& loads, const double* u, Workspace<A>& ws) {
  for (std::size_t i = 0; i < model.links.size(); ++i) ws.F_ext[i] = {};
  for (const PointSpring& spring : loads.springs) spring_load(spring, ws);
  for (const Wrench& wrench : loads.wrenches) wrench_load(wrench, u, ws);
}

template <class A>
void counted_cut_coordinates(const typename Model<A>::Cut& cut, const typename A::Pose& X_FM, const double* reference,
                             double* q) {
  for (int i = 0; i < cut.nq; ++i) q[i] = reference[i];
  visit_joint<A>(cut.joint, [&](const auto& joint) { joint.template coordinates<A>(X_FM, q); });
  const auto names = kind_of(cut.joint).q;
  for (int i = 0; i < cut.nq; ++i) {
    if (names[i].unit == "rad") q[i] += 2 * M_PI * std::round((reference[i] - q[i]) / (2 * M_PI));
  }
}

template <class A>
void cut_speeds(const typename Model<A>::Cut& cut, const Workspace<A>& ws, int c, const double* q, double* v) {
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
void cut_loads(const Model<A>& model, const Loads& loads, const double* u, const double* reference, Workspace<A>& ws) {
  for (int c = 0; c < static_cast<int>(model.cuts.size()); ++c) {
    ws.F_cut[c] = {};
    const JointLoads& on = loads.cuts[c];
    if (on.empty()) continue;
    const auto& cut = model.cuts[c];
    double q[7], v[6];
    counted_cut_coordinates<A>(cut, ws.X_FM[c], reference + cut.iq, q);
    cut_speeds<A>(cut, ws, c, q, v);
    double tau[6] = {};
    on.add(q, v, u, tau);
    const typename A::Force F_M = visit_joint<A>(
        cut.joint, [&](const auto& joint) -> typename A::Force { return joint.template effort<A>(q, tau); });
    ws.F_cut[c] = F_M;
    ws.F_ext[cut.link_b] += cut.X_BM.to_parent(F_M);
    ws.F_ext[cut.link_a] -= cut.X_AF.to_parent(ws.X_FM[c].to_parent(F_M));
  }
}

#define GELENK_INSTANTIATE(A)                                                                             \
  template Vector3d spring_span<A>(const PointSpring&, const Workspace<A>&);                              \
  template void link_loads(const Model<A>&, const Loads&, const double*, Workspace<A>&);                  \
  template void cut_loads(const Model<A>&, const Loads&, const double*, const double*, Workspace<A>&);    \
  template void counted_cut_coordinates<A>(const Model<A>::Cut&, const A::Pose&, const double*, double*); \
  template void cut_speeds<A>(const Model<A>::Cut&, const Workspace<A>&, int, const double*, double*);
GELENK_INSTANTIATE(Planar)
GELENK_INSTANTIATE(Spatial)
#undef GELENK_INSTANTIATE

}  // namespace gelenk::kernels
