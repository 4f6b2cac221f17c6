// SPDX-License-Identifier: BSD-3-Clause
// The loads of a scene in the form in which the kernels read them.
#pragma once

#include <string_view>
#include <unordered_map>
#include <vector>

#include "kinematics/loads.h"
#include "scene/scene.h"

namespace gelenk {

// The scene's loads by island, with their signs and positions. Inputs are numbered as in scene/signals.h. Allocates.
std::vector<Loads> make_loads(const Scene& scene, const ReducedScene& reduced);

// The same for repeated use after parameter changes: fill() overwrites loads of the same scene without allocating
// memory. `scene` and `reduced` must outlive it.
class LoadAssembler {
 public:
  LoadAssembler(const Scene& scene, const ReducedScene& reduced);
  void fill(std::vector<Loads>& loads) const;

 private:
  const Scene& scene_;
  const ReducedScene& reduced_;
  std::unordered_map<std::string_view, int> body_number_, joint_number_;
  std::vector<std::vector<int>> inputs_;
};

// Potential energy [J] of immobile bodies, springs and stops; gravity's is zero at the world's origin.
double immobile_energy(const Scene& scene, const ReducedScene& reduced);

}  // namespace gelenk
