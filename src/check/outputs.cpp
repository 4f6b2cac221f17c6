// SPDX-License-Identifier: BSD-3-Clause
#include "check/check.h"
#include "scene/wanted_outputs.h"

namespace gelenk {

void check_outputs(const Scene& scene, Faults& faults, bool partial) {
  if (partial || scene.outputs.empty()) return;
  const std::vector<std::string> found = faults_of_outputs(scene, scene.outputs);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i].empty()) faults.add("outputs[" + std::to_string(i + 1) + "]", found[i]);
  }
}

}  // namespace gelenk
