// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <tuple>

#include "element/registry.h"

namespace gelenk {

// Whether dry friction can keep the coordinate at rest.
inline bool has_friction(const JointForces& forces) {
  return std::get<std::optional<JointFriction>>(forces).has_value();
}

}  // namespace gelenk
