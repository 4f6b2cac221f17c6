// SPDX-License-Identifier: BSD-3-Clause
// The states with respect to which a simulation is differentiated.
#pragma once

#include <vector>

#include "mechanism/mechanism.h"
#include "scene/signals.h"

namespace gelenk {

// Independent outputs: coordinates (all four components of a quaternion or none), velocities, and all element states.
struct IndependentOutputs {
  std::vector<int> coordinates, speeds, elements{};
  bool operator==(const IndependentOutputs&) const = default;
  // The corresponding states: the coordinates, the velocities, the element states.
  std::vector<int> states() const {
    std::vector<int> out = coordinates;
    out.insert(out.end(), speeds.begin(), speeds.end());
    out.insert(out.end(), elements.begin(), elements.end());
    return out;
  }
};

// For each velocity of the island, whether its coordinate (level 0) or the velocity itself (level 1) is among these
// outputs. A quaternion sets the flags of its three angular velocities.
std::vector<bool> speeds_of(const Scene& scene, const ReducedScene& reduced, const std::vector<Signal>& outputs,
                            int island, int level, const std::vector<int>& among);

}  // namespace gelenk
