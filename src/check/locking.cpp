// SPDX-License-Identifier: BSD-3-Clause
// Friction together with gears and racks that have losses, and with several coordinates.
#include <algorithm>
#include <string>

#include "check/check.h"
#include "element/locking.h"
#include "joint/kinds.h"
#include "scene/element_numbers.h"
#include "util/text.h"

namespace gelenk {
namespace {

std::string path_of(const Joint& joint) { return "joints." + text::printable(joint.name); }

const Joint* joint_named(const Scene& scene, const std::string& name) {
  const auto at = std::ranges::find(scene.joints, name, &Joint::name);
  return at == scene.joints.end() ? nullptr : &*at;
}

void check_mesh(const Scene& scene, const Constraint& c, Faults& faults) {
  const int lossy = lossy_joint(*c.is);
  if (lossy < 0) return;
  const Joint* joint = joint_named(scene, c.joints[static_cast<std::size_t>(lossy)]);
  if (joint == nullptr) return;  // reported already
  if (joint->along.size() > 1) {
    faults.add("constraints." + text::printable(c.name) + ".efficiency",
               text::quoted(joint->name) + ", " + a_kind(kind_of(*joint->is)), "a joint with one coordinate");
    return;
  }
  if (std::ranges::any_of(joint->along, takes_loads, &Stored<JointForces>::value)) return;
  faults.add("constraints." + text::printable(c.name) + ".efficiency",
             "a joint " + text::quoted(joint->name) + " without friction",
             path_of(*joint) + ".friction, to which the losses of the mesh are added (coulomb: 0 for these alone)");
}

// The force across its axis is that of a joint with one coordinate.
void check_bearings(const Joint& joint, Faults& faults) {
  if (joint.along.size() < 2) return;
  const JointKind& kind = kind_of(*joint.is);
  for (std::size_t i = 0; i < joint.along.size(); ++i) {
    if (!has_bearing(*joint.along[i])) continue;
    faults.add(path_of(joint) + "." + group_along("friction", kind, static_cast<int>(i)) + ".bearing",
               "a bearing of " + a_kind(kind), "none, or a joint with one coordinate");
  }
}

}  // namespace

void check_locking(const Scene& scene, Faults& faults) {
  for (const Joint& joint : scene.joints) check_bearings(joint, faults);
  for (const Constraint& c : scene.constraints) check_mesh(scene, c, faults);
}

}  // namespace gelenk
