// SPDX-License-Identifier: BSD-3-Clause
// The states that derivatives of a simulation are taken by.
#pragma once

#include <vector>

#include "mechanism/mechanism.h"
#include "scene/signals.h"

namespace gelenk {

// A number of the state: a coordinate or a speed, as its output.
struct StateVariable {
  static constexpr int none = -1;
  int output = none;
  int derivative = none;  // the output that is its time derivative; none: a quaternion's component, whose is no output
};

// Outputs that are independent: coordinates, of a quaternion all four or none, and speeds.
struct IndependentOutputs {
  std::vector<int> coordinates, speeds;
  bool operator==(const IndependentOutputs&) const = default;
};

// The states that these are: the coordinates, then the speeds.
std::vector<StateVariable> states_of(const Scene& scene, const std::vector<Signal>& outputs,
                                     const IndependentOutputs& independent);

// By speed of the island: its coordinate (level 0), or it itself (1), is among these outputs.
std::vector<bool> speeds_of(const Scene& scene, const ReducedScene& reduced, const std::vector<Signal>& outputs,
                            int island, int level, const std::vector<int>& among);

}  // namespace gelenk
