// SPDX-License-Identifier: BSD-3-Clause
// The list of all forces on bodies. A new one requires a header and its name here.
#pragma once

#include <variant>

#include "element/forces/body_force.h"
#include "element/forces/bushing.h"
#include "element/forces/drag.h"
#include "element/forces/line_force.h"
#include "element/forces/moment.h"
#include "element/forces/spring_damper.h"
#include "element/forces/tire.h"
#include "element/forces/wrench.h"

namespace gelenk {

struct AnyForce : std::variant<SpringDamper, Wrench, Bushing, Drag, Moment, Tire, LineForce, BodyForce> {
  using variant::variant;
};

}  // namespace gelenk
