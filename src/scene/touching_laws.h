// SPDX-License-Identifier: BSD-3-Clause
// The laws of a scene that are contacts to the equations: its contacts of shapes, and after them the limits of ball
// joints. They have one numbering.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "element/contacts/contact.h"
#include "scene/scene.h"

namespace gelenk {

// The joints with a limit of their swing, in the order of these limits.
std::vector<int> joints_with_swing_limit(const Scene& scene);
// The output signals of such a limit: the size of its torque, and whether it acts.
std::span<const SignalGroup> swing_limit_outputs();
// Whether a scene has such laws, and how many.
bool has_touching_laws(const Scene& scene);
std::size_t touching_law_count(const Scene& scene);
// The numbers of all of them.
std::vector<ContactLaw> touching_laws(const Scene& scene);
// The place of one in the file, for messages: "contacts.floor", "joints.shoulder.limit"; and its name in outputs.
std::string path_of_touching_law(const Scene& scene, int number);
std::string name_of_touching_law(const Scene& scene, int number);
std::vector<std::string> names_of_touching_laws(const Scene& scene);

}  // namespace gelenk
