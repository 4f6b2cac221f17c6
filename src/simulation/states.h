// SPDX-License-Identifier: BSD-3-Clause
// The states that derivatives of a simulation are taken by.
#pragma once

#include <vector>

#include "mechanism/mechanism.h"
#include "simulation/signals.h"

namespace gelenk {

// A number of the state: a coordinate or a speed, as its output.
struct StateVariable {
  static constexpr int none = -1;
  int output = none;
  int derivative = none;  // the output that is its time derivative; none: a quaternion's component, whose is no output
};

// The states behind these coordinates: the coordinates, then their speeds. A joint with a quaternion has them where all
// three turns are independent.
std::vector<StateVariable> states_behind(const Scene& scene, const std::vector<Signal>& outputs,
                                         const std::vector<int>& independent_coordinates);

// By speed of the island: it belongs to one of these states.
std::vector<bool> speeds_behind(const ReducedScene& reduced, const std::vector<Signal>& outputs, int island,
                                const std::vector<StateVariable>& states);

}  // namespace gelenk
