// SPDX-License-Identifier: BSD-3-Clause
// The laws of a scene that are contacts to the equations: its contacts of shapes, and after them those of joints, the
// limits of ball joints and friction along several velocities together. They have one numbering.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "element/contacts/contact.h"
#include "joint/isotropic_friction.h"
#include "scene/scene.h"

namespace gelenk {

struct SwingLimit;

// One of a joint.
struct TouchingLawOfJoint {
  int joint = 0;
  const SwingLimit* swing = nullptr;          // the limit of its swing; or
  std::optional<FrictionPart> friction = {};  // its friction

  std::string_view key() const { return friction ? friction->key : "limit"; }
  bool turns() const { return !friction || friction->turns; }
};
// In the order of their numbers.
std::vector<TouchingLawOfJoint> touching_laws_of_joints(const Scene& scene);
// The one with this number among all; nothing: a contact of shapes.
std::optional<TouchingLawOfJoint> touching_law_of_joint(const Scene& scene, int number);
// The output signals of such a law: its force, and its mode.
std::span<const SignalGroup> outputs_of(const TouchingLawOfJoint& law);
// Whether a scene has laws that are contacts, and how many.
bool has_touching_laws(const Scene& scene);
std::size_t touching_law_count(const Scene& scene);
// The numbers of all of them.
std::vector<ContactLaw> touching_laws(const Scene& scene);
// The place of one in the file, for messages: "contacts.floor", "joints.shoulder.limit"; and its name in outputs.
std::string path_of_touching_law(const Scene& scene, int number);
std::string name_of_touching_law(const Scene& scene, int number);
std::vector<std::string> names_of_touching_laws(const Scene& scene);

}  // namespace gelenk
