// SPDX-License-Identifier: BSD-3-Clause
// The list of all sensors. A new one requires a header and its name here.
#pragma once

#include <variant>

#include "element/sensors/distance.h"
#include "element/sensors/energy_sensor.h"
#include "element/sensors/frame_sensor.h"
#include "element/sensors/power.h"
#include "element/sensors/reaction.h"

namespace gelenk {

struct AnySensor : std::variant<Reaction, FrameSensor, EnergySensor, Distance, Power> {
  using variant::variant;
};

}  // namespace gelenk
