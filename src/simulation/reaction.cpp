// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/reaction.h"

#include "math/dual.h"
#include "math/pose_in.h"
#include "math/series.h"

namespace gelenk {

Reaction::Reaction(const Scene& scene, const ReducedScene& reduced, int joint) {
  const JointPlace& place = reduced.joints[joint];
  const Mechanism& mechanism = reduced.islands[place.island];
  cut_ = place.role == JointPlace::Role::cut;
  index_ = place.index;
  side_ = !cut_ && mechanism.links[index_].reversed ? -1 : 1;
  at_ = cut_ ? BodyPlace{place.island, mechanism.cuts[index_].link_b, mechanism.cuts[index_].X_BM, -1}
             : BodyPlace{place.island, index_, Pose3(), -1};
  frame_M_ = gelenk::place(scene, reduced, place.island, scene.joints[joint].child);
  frame_F_ = gelenk::place(scene, reduced, place.island, scene.joints[joint].parent);
}

template <class T>
T Reaction::component(int i, const Readings<T>& dynamics) const {
  const auto in_numbers = [](const Pose3& X) { return pose_in<SpatialAlgebra<T>>(X); };
  const auto X_0J = dynamics.link_pose(at_.link) * in_numbers(at_.X_LB);
  const auto F = cut_ ? dynamics.cut_reaction(index_) : dynamics.tree_reaction(index_);
  const auto X_0M = dynamics.link_pose(frame_M_.link) * in_numbers(frame_M_.X_LB);
  const Matrix3<T> R_0F = dynamics.link_pose(frame_F_.link).R * in_numbers(frame_F_.X_LB).R;
  const Vector3<T> f = T(side_) * (X_0J.R * F.f);
  if (i < 3) return R_0F.col(i).dot(f);
  const Vector3<T> n = T(side_) * (X_0J.R * F.n) + Vector3<T>(X_0J.p - X_0M.p).cross(f);
  return R_0F.col(i - 3).dot(n);
}

template double Reaction::component(int, const Readings<double>&) const;
template Dual Reaction::component(int, const Readings<Dual>&) const;
template Series Reaction::component(int, const Readings<Series>&) const;

}  // namespace gelenk
