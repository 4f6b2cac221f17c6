// SPDX-License-Identifier: BSD-3-Clause
// Friction together with gears and racks that have losses.
#include <algorithm>
#include <string>

#include "check/check.h"
#include "element/locking.h"
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
  if (std::ranges::any_of(joint->along, takes_loads, &Stored<JointForces>::value)) return;
  faults.add("constraints." + text::printable(c.name) + ".efficiency",
             "a joint " + text::quoted(joint->name) + " without friction",
             path_of(*joint) + ".friction, to which the losses of the mesh are added (coulomb: 0 for these alone)");
}

}  // namespace

void check_locking(const Scene& scene, Faults& faults) {
  for (const Constraint& c : scene.constraints) check_mesh(scene, c, faults);
}

}  // namespace gelenk
