// SPDX-License-Identifier: BSD-3-Clause
#include "simulation/reaction.h"

namespace gelenk {

using Eigen::Vector3d;

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

double Reaction::component(int i, const Dynamics& dynamics) const {
  const Pose3 X_0J = dynamics.link_pose(at_.link) * at_.X_LB;
  const Spatial::Force F = cut_ ? dynamics.cut_reaction(index_) : dynamics.tree_reaction(index_);
  const Pose3 X_0M = dynamics.link_pose(frame_M_.link) * frame_M_.X_LB;
  const Eigen::Matrix3d R_0F = dynamics.link_pose(frame_F_.link).R * frame_F_.X_LB.R;
  const Vector3d f = side_ * (X_0J.R * F.f);
  if (i < 3) return R_0F.col(i).dot(f);
  const Vector3d n = side_ * (X_0J.R * F.n) + (X_0J.p - X_0M.p).cross(f);
  return R_0F.col(i - 3).dot(n);
}

}  // namespace gelenk
