// SPDX-License-Identifier: BSD-3-Clause
// Start values of a joint as scene files group them: arrays as a whole, scalars one by one.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "joint/kind.h"
#include "scene/scene.h"

namespace gelenk {

// Coordinates or velocities that a file gives together: "Q" for Q[1] to Q[4]; a scalar is a group of its own.
struct QuantityGroup {
  std::string name;
  std::string unit;
  std::string description;
  std::size_t first = 0;  // index of its first quantity
  std::size_t size = 1;
  bool array = false;
};
// Groups the coordinates or velocities of a joint.
std::vector<QuantityGroup> groups(std::span<const Quantity> quantities);

// The parameter that sets a start value: "phi" -> "A.phi_start", "Q[2]" -> "S.Q_start[2]".
std::string start_parameter(const std::string& joint, std::string_view quantity);
// That of an element state: "i" -> "i_start".
inline std::string start_parameter(const std::string& state) { return state + "_start"; }

inline constexpr double default_start_weight = 1;  // weight of a guess if the file gives none

// Returns start values that are all free guesses: the reference configuration at rest.
JointStart free_start(const JointKind& kind);

}  // namespace gelenk
