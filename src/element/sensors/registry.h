// SPDX-License-Identifier: BSD-3-Clause
// The list of all sensors. A new one requires a header and its name here.
#pragma once

#include <variant>

#include "element/sensors/distance.h"
#include "element/sensors/energy_sensor.h"
#include "element/sensors/euler_angles.h"
#include "element/sensors/frame_sensor.h"
#include "element/sensors/imu.h"
#include "element/sensors/power.h"
#include "element/sensors/reaction.h"
#include "element/sensors/relative.h"

namespace gelenk {

struct AnySensor : std::variant<Reaction, FrameSensor, EnergySensor, Distance, Power, Imu, Relative, EulerAngles> {
  using variant::variant;
};

}  // namespace gelenk
