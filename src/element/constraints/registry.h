// SPDX-License-Identifier: BSD-3-Clause
// The list of all constraints. A new one requires a header and its name here.
#pragma once

#include <variant>

#include "element/constraints/coupling.h"
#include "element/constraints/gear.h"
#include "element/constraints/knife_edge.h"
#include "element/constraints/motion.h"
#include "element/constraints/point_on_surface.h"
#include "element/constraints/rack.h"
#include "element/constraints/relation.h"
#include "element/constraints/rolling.h"

namespace gelenk {

struct AnyConstraint : std::variant<Motion, Gear, Rack, Coupling, Rolling, KnifeEdge, PointOnSurface, Relation> {
  using variant::variant;
};

}  // namespace gelenk
