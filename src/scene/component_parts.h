// SPDX-License-Identifier: BSD-3-Clause
// What components (element/components/component.h) add to a scene: inputs, states and named expressions, with the name
// of the component before a dot, and efforts along joints; of those between two points a sensor of their distance and a
// force along their line, with the name of the component. All but the efforts are entries of the scene as those of the
// file are.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace gelenk {

// Adds what expressions may name of the components of a scene, by texts: nothing of them has been read or added yet.
void add_component_names(const Scene& scene, FormulaNames& names);

// Adds the parts of all components to the scene that has them. names: all that they may name, with their own parts.
// fault(component, found): of equations that cannot be read, such as those of expressions that name too much.
void add_component_parts(Scene& scene, const FormulaNames& names,
                         const std::function<void(const Component&, const std::string&)>& fault);

// Adds the numbers of components, in SI units, as constants: "M.resistance".
void add_component_constants(const Scene& scene, std::vector<FormulaNames::Constant>& constants);

// The name of a part within its component: "i" of "M.i".
template <class Part>
std::string own_name(const Part& part) {
  return part.name.substr(part.component.size() + 1);
}

// The joints that a motor or a component drives, with the inertia that it adds there [kg m2, kg].
struct DrivenJoint {
  std::string_view joint;
  double inertia = 0;
  std::string path;  // of the motor or component in the file, "motors.M"
};
std::vector<DrivenJoint> driven_joints(const Scene& scene);

}  // namespace gelenk
