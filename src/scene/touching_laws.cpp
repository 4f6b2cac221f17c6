// SPDX-License-Identifier: BSD-3-Clause
#include "scene/touching_laws.h"

#include <algorithm>

#include "joint/swing_limit.h"

namespace gelenk {
namespace {

// The largest friction is the normal force of which the coefficients are parts.
ContactLaw law_of(const FrictionPart& friction) {
  ContactLaw out;
  if (!(friction.at_rest > 0)) return out;
  out.given_normal = friction.at_rest;
  out.static_friction = 1;
  out.sliding_friction = friction.sliding / friction.at_rest;
  return out;
}

bool has_touching_law(const Joint& joint) {
  return swing_limit_of(*joint.is) != nullptr || !friction_parts_of(*joint.is).empty();
}

}  // namespace

std::vector<TouchingLawOfJoint> touching_laws_of_joints(const Scene& scene) {
  std::vector<TouchingLawOfJoint> out;
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const AnyJoint& joint = *scene.joints[j].is;
    const int number = static_cast<int>(j);
    if (const SwingLimit* swing = swing_limit_of(joint)) out.push_back({.joint = number, .swing = swing});
    for (const FrictionPart& friction : friction_parts_of(joint))
      out.push_back({.joint = number, .friction = friction});
  }
  return out;
}

std::optional<TouchingLawOfJoint> touching_law_of_joint(const Scene& scene, int number) {
  const auto i = static_cast<std::size_t>(number);
  if (i < scene.contacts.size()) return {};
  return touching_laws_of_joints(scene).at(i - scene.contacts.size());
}

std::span<const SignalGroup> outputs_of(const TouchingLawOfJoint& law) {
  static constexpr SignalGroup of_swing[] = {
      {"tau", 0, "N.m",
       "contact torque at the limit of the swing, towards less swing; impacts count in time steps alone"},
      {"mode", 0, "1", "1: the swing is in contact with its limit; 0: it is not"}};
  static constexpr std::string_view moment = "dry friction on the child, along the axes of the angular velocity";
  static constexpr std::string_view force = "dry friction on the child, along the axes of the velocity";
  static constexpr std::string_view mode = "1: the joint slips; 0: friction keeps it at rest";
  static constexpr SignalGroup of_rotation[] = {{"tau", 3, "N.m", moment}, {"mode", 0, "1", mode}};
  static constexpr SignalGroup in_plane[] = {{"f", 2, "N", force}, {"mode", 0, "1", mode}};
  static constexpr SignalGroup in_space[] = {{"f", 3, "N", force}, {"mode", 0, "1", mode}};
  if (!law.friction) return of_swing;
  if (law.friction->turns) return of_rotation;
  if (law.friction->dimension == 2) return in_plane;
  return in_space;
}

bool has_touching_laws(const Scene& scene) {
  return !scene.contacts.empty() || std::ranges::any_of(scene.joints, has_touching_law);
}

std::size_t touching_law_count(const Scene& scene) {
  return scene.contacts.size() + touching_laws_of_joints(scene).size();
}

std::vector<ContactLaw> touching_laws(const Scene& scene) {
  std::vector<ContactLaw> out;
  for (const Contact& contact : scene.contacts) out.push_back(law_of(*contact.is));
  for (const TouchingLawOfJoint& of : touching_laws_of_joints(scene)) {
    if (of.friction) {
      out.push_back(law_of(*of.friction));
    } else {
      out.emplace_back().restitution = of.swing->restitution;
    }
  }
  return out;
}

std::string name_of_touching_law(const Scene& scene, int number) {
  const std::optional<TouchingLawOfJoint> of = touching_law_of_joint(scene, number);
  if (!of) return scene.contacts[static_cast<std::size_t>(number)].name;
  return scene.joints[static_cast<std::size_t>(of->joint)].name + "." + std::string(of->key());
}

std::vector<std::string> names_of_touching_laws(const Scene& scene) {
  std::vector<std::string> out;
  const auto count = static_cast<int>(touching_law_count(scene));
  for (int i = 0; i < count; ++i) out.push_back(name_of_touching_law(scene, i));
  return out;
}

std::string path_of_touching_law(const Scene& scene, int number) {
  const bool is_contact = static_cast<std::size_t>(number) < scene.contacts.size();
  return (is_contact ? "contacts." : "joints.") + name_of_touching_law(scene, number);
}

}  // namespace gelenk
