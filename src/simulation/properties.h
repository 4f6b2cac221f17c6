// SPDX-License-Identifier: BSD-3-Clause
// The numbers of bodies, joints, motors and forces that a scene may offer as parameters.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "simulation/parameters.h"

namespace gelenk {

struct Property {
  std::string path;          // in the scene file: "crank.com"
  std::string element_path;  // "crank.com[1]"; as path, where there is no array
  Parameter parameter;
};

// Every one there is, bodies first, then joints, motors, forces, each in file order.
std::vector<Property> scene_properties(const Scene& scene);

// access(scene) gives a reference to the number, in a Scene as in a const Scene.
template <class Access>
Parameter real_parameter(std::string name, std::string_view unit, std::string description, Access access) {
  Parameter p;
  p.name = std::move(name);
  p.unit = unit;
  p.description = std::move(description);
  p.get = [access](const Scene& scene) -> double { return access(scene); };
  p.put = [access](Scene& scene, double value) { access(scene) = value; };
  return p;
}

}  // namespace gelenk
