// SPDX-License-Identifier: BSD-3-Clause
// Friction, limits and one-way clutches together with each other, with gears and racks that have losses, and with
// contacts.
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

// The field with the friction that depends on forces of the mechanism; empty: there is none.
std::string loaded_friction(const Scene& scene) {
  for (const Joint& joint : scene.joints) {
    if (std::ranges::any_of(joint.along, has_bearing, &Stored<JointForces>::value))
      return path_of(joint) + ".friction.bearing";
  }
  for (const Constraint& c : scene.constraints) {
    if (lossy_joint(*c.is) >= 0) return "constraints." + text::printable(c.name) + ".efficiency";
  }
  return {};
}

void check_mesh(const Scene& scene, const Constraint& c, Faults& faults) {
  const int lossy = lossy_joint(*c.is);
  if (lossy < 0) return;
  const Joint* joint = joint_named(scene, c.joints[static_cast<std::size_t>(lossy)]);
  if (joint == nullptr) return;  // reported already
  if (std::ranges::any_of(joint->along, has_friction, &Stored<JointForces>::value)) return;
  faults.add("constraints." + text::printable(c.name) + ".efficiency",
             "a joint " + text::quoted(joint->name) + " without friction",
             path_of(*joint) + ".friction, to which the losses of the mesh are added (coulomb: 0 for these alone)");
}

}  // namespace

void check_locking(const Scene& scene, Faults& faults) {
  for (const Joint& joint : scene.joints) {
    if (!std::ranges::any_of(joint.along, has_two_bounds, &Stored<JointForces>::value)) continue;
    faults.add(path_of(joint) + ".one_way", "a limit of the same coordinate",
               "only one of the two: a one-way clutch and a limit need a joint each, with a body between them");
  }
  for (const Constraint& c : scene.constraints) check_mesh(scene, c, faults);
  const std::string loaded = loaded_friction(scene);
  if (loaded.empty()) return;
  if (!scene.contacts.empty()) {
    faults.add(loaded, "also contacts." + text::printable(scene.contacts.front().name),
               "no contacts: friction that depends on loads is not decided together with contacts between shapes");
  } else if (scene.solver.integrator == "moreau-jean") {
    faults.add(loaded, "the integrator 'moreau-jean'",
               "another integrator: friction that depends on loads needs events, at which it changes");
  }
}

}  // namespace gelenk
