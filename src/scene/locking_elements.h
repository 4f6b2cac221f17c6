// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/locking.h"
#include "scene/scene.h"

namespace gelenk {

// Removes friction and limits. They do not affect the constraint equations of joints, but where loops can be cut.
inline void erase_locking_elements(Scene& scene) {
  for (Joint& joint : scene.joints) {
    for (Stored<JointForces>& forces : joint.along) erase_locking_elements(*forces);
  }
}

}  // namespace gelenk
