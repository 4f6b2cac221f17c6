// SPDX-License-Identifier: BSD-3-Clause
#include "preparation/law_report.h"

#include "kinematics/switching_force.h"
#include "scene/element_numbers.h"
#include "scene/touching_laws.h"
#include "util/text.h"

namespace gelenk {
namespace {

// x: in natural units. unit: as in field/field.h, "N.m".
std::string shown(const Scene& scene, double x, const std::string& unit) {
  return text::with_unit(text::rounded(x * scene.units.size_of(unit)), spelled(unit));
}

std::string of_joint(const Scene& scene, const Loads& loads, const BrokenLaw& broken) {
  const SwitchingForce of = switching_forces_of(loads)[static_cast<std::size_t>(broken.index)];
  const Joint& joint = scene.joints[static_cast<std::size_t>(of.joint)];
  const Coordinate at = coordinate_of(kind_of(*joint.is), of.component);
  const std::string force = shown(scene, broken.found, unit_of("{f}", at));
  const std::string law = "joints." + joint.name + "." + group_along(of.group, kind_of(*joint.is), of.component);
  switch (broken.kind) {
    case BrokenLaw::Kind::friction_exceeded:
      return law + ": the friction would be " + force + ", but can be at most " +
             shown(scene, broken.bound, unit_of("{f}", at));
    case BrokenLaw::Kind::friction_along_motion:
      return law + ": the friction would be " + force + ", along the motion with " +
             shown(scene, broken.bound, unit_of("{v}", at));
    case BrokenLaw::Kind::latch_moves:
      return law + ": it is engaged, and the joint moves with " + shown(scene, broken.found, unit_of("{v}", at));
    case BrokenLaw::Kind::limit_not_reached:
      return law + ": the limit would exert " + force + " at a distance of " +
             shown(scene, broken.bound, unit_of("{q}", at));
    case BrokenLaw::Kind::limit_passed:
      return law + ": the coordinate is " + shown(scene, broken.bound, unit_of("{q}", at)) + " beyond its limit";
    default:
      return law + ": it would pull with " + force;
  }
}

bool is_of_contact(BrokenLaw::Kind kind) {
  return kind == BrokenLaw::Kind::contact_pulls || kind == BrokenLaw::Kind::contact_friction ||
         kind == BrokenLaw::Kind::contact_moment || kind == BrokenLaw::Kind::contact_approaches;
}

std::string of_contact(const Scene& scene, const BrokenLaw& broken) {
  const std::string law = path_of_touching_law(scene, broken.index);
  const std::optional<TouchingLawOfJoint> of_joint = touching_law_of_joint(scene, broken.index);
  const bool turns = of_joint && of_joint->turns();
  if (broken.kind == BrokenLaw::Kind::contact_pulls)
    return law + ": the normal force would pull with " + shown(scene, -broken.found, turns ? "N.m" : "N");
  if (broken.kind == BrokenLaw::Kind::contact_approaches)
    return law + ": surfaces that touch would approach each other with " +
           shown(scene, broken.found, turns ? "rad/s" : "m/s") +
           ", since no impulses were found that prevent it (as where a heavy body rests on one of far less mass)";
  const bool is_moment = turns || broken.kind == BrokenLaw::Kind::contact_moment;
  const std::string unit = is_moment ? "N.m" : "N";
  return law + (is_moment ? ": the moment of friction would be " : ": the friction would be ") +
         shown(scene, broken.found, unit) + ", but can be at most " + shown(scene, broken.bound, unit);
}

}  // namespace

std::string owner_of_branch(const Scene& scene, const Mechanism& mechanism, const BranchPlace& place) {
  const auto i = static_cast<std::size_t>(place.index);
  switch (place.of) {
    case BranchPlace::Of::joint:
      return scene.joints[i].name + ".law";
    case BranchPlace::Of::friction:
      return scene.joints[i].name + ".friction";
    case BranchPlace::Of::component:
      return scene.components[i].name;
    case BranchPlace::Of::force:
      return scene.forces[i].name;
    case BranchPlace::Of::mesh:
    case BranchPlace::Of::motion:
      return scene.constraints[static_cast<std::size_t>(mechanism.coordinate_rows[i].constraint)].name;
    case BranchPlace::Of::state:
      return scene.states[static_cast<std::size_t>(mechanism.states[i])].name + ".rate";
    case BranchPlace::Of::reset:
      return scene.states[static_cast<std::size_t>(mechanism.states[i])].name + ".resets";
    case BranchPlace::Of::gravity:
      break;
  }
  return "gravity";
}

std::string describe_shared_load(const Scene& scene, const Loads& loads, int contact, int force) {
  const SwitchingForce of = switching_forces_of(loads)[static_cast<std::size_t>(force)];
  const std::string joint = scene.joints[static_cast<std::size_t>(of.joint)].name;
  return name_of_touching_law(scene, contact) + ": how it shares its load with " + joint +
         ", which is held, is not determined for rigid bodies, but its friction depends on it: more than one motion is "
         "possible";
}

std::string describe_broken_law(const Scene& scene, const Loads& loads, const BrokenLaw& broken) {
  return (is_of_contact(broken.kind) ? of_contact(scene, broken) : of_joint(scene, loads, broken)) +
         "; no result outside the laws is returned: try a smaller communication step or tolerance, or another "
         "integrator";
}

}  // namespace gelenk
