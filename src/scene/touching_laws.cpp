// SPDX-License-Identifier: BSD-3-Clause
#include "scene/touching_laws.h"

#include <algorithm>

#include "joint/swing_limit.h"

namespace gelenk {

std::vector<int> joints_with_swing_limit(const Scene& scene) {
  std::vector<int> out;
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    if (swing_limit_of(*scene.joints[j].is) != nullptr) out.push_back(static_cast<int>(j));
  }
  return out;
}

std::span<const SignalGroup> swing_limit_outputs() {
  static constexpr SignalGroup all[] = {
      {"tau", 0, "N.m",
       "contact torque at the limit of the swing, towards less swing; impacts count in time steps alone"},
      {"mode", 0, "1", "1: the swing is in contact with its limit; 0: it is not"}};
  return all;
}

bool has_touching_laws(const Scene& scene) {
  return !scene.contacts.empty() ||
         std::ranges::any_of(scene.joints, [](const Joint& joint) { return swing_limit_of(*joint.is) != nullptr; });
}

std::size_t touching_law_count(const Scene& scene) {
  return scene.contacts.size() + joints_with_swing_limit(scene).size();
}

std::vector<ContactLaw> touching_laws(const Scene& scene) {
  std::vector<ContactLaw> out;
  for (const Contact& contact : scene.contacts) out.push_back(law_of(*contact.is));
  for (const int j : joints_with_swing_limit(scene)) {
    ContactLaw& law = out.emplace_back();
    law.restitution = swing_limit_of(*scene.joints[static_cast<std::size_t>(j)].is)->restitution;
  }
  return out;
}

std::string name_of_touching_law(const Scene& scene, int number) {
  const auto i = static_cast<std::size_t>(number);
  if (i < scene.contacts.size()) return scene.contacts[i].name;
  const int joint = joints_with_swing_limit(scene).at(i - scene.contacts.size());
  return scene.joints[static_cast<std::size_t>(joint)].name + ".limit";
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
