// SPDX-License-Identifier: BSD-3-Clause
#include "outputs/port_readings.h"

#include <algorithm>

namespace gelenk {

Pose3 pose_in_world(const ReducedScene& reduced, const BodyPlace& body, const Readings<double>& dynamics) {
  if (body.island < 0) return body.X_LB;
  return reduced.islands[static_cast<std::size_t>(body.island)].X_W0 * carrier_pose(body, dynamics) * body.X_LB;
}

JointWrench::JointWrench(const Scene& scene, const ReducedScene& reduced, int joint) {
  const JointPlace& where = reduced.joints[static_cast<std::size_t>(joint)];
  const Mechanism& mechanism = reduced.islands[static_cast<std::size_t>(where.island)];
  cut = where.role == JointPlace::Role::cut;
  index = where.index;
  side = !cut && mechanism.links[static_cast<std::size_t>(index)].reversed ? -1 : 1;
  const auto c = static_cast<std::size_t>(index);
  at = cut ? BodyPlace{where.island, mechanism.cuts[c].link_b, mechanism.cuts[c].X_BM, -1}
           : BodyPlace{where.island, index, Pose3(), -1};
  const Joint& of = scene.joints[static_cast<std::size_t>(joint)];
  M = place(scene, reduced, where.island, of.child);
  F = place(scene, reduced, where.island, of.parent);
}

PortPlaces::PortPlaces(const Scene& scene, const ReducedScene& reduced, const ElementPlace& element, bool with_wrench)
    : gravity(scene.gravity) {
  std::vector<const BodyFrame*> all;
  for (const BodyFrame& frame : element.frames) all.push_back(&frame);
  for (const std::string& name : element.joints) {
    const auto found = std::ranges::find(scene.joints, name, &Joint::name);
    const auto j = static_cast<std::size_t>(found - scene.joints.begin());
    all.push_back(&found->parent);
    all.push_back(&found->child);
    island = std::max(island, reduced.joints[j].island);
    if (with_wrench) wrench.emplace(scene, reduced, static_cast<int>(j));
  }
  for (const BodyFrame* frame : all) island = std::max(island, place(scene, reduced, -1, *frame).island);
  for (const BodyFrame* frame : all) frames.push_back(place(scene, reduced, island, *frame));
}

}  // namespace gelenk
