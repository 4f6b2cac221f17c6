// SPDX-License-Identifier: BSD-3-Clause
// Names and units of a joint's fields, from its kind.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "joint/kind.h"
#include "scene/scene.h"

namespace gelenk {

// Coordinates or speeds that a file gives together: "Q" for Q[1] to Q[4]; a scalar alone.
struct QuantityGroup {
  std::string name;
  std::string unit;
  std::string description;
  std::size_t first = 0;  // place of its first element
  std::size_t size = 1;
  bool array = false;
};
std::vector<QuantityGroup> groups(std::span<const Quantity> quantities);

inline constexpr double default_start_weight = 1;

// Start values of which nothing is given: the reference configuration at rest.
JointStart free_start(const JointKind& kind);

}  // namespace gelenk
