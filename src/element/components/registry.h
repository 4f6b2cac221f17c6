// SPDX-License-Identifier: BSD-3-Clause
// The list of all components. A new one requires a header and its name here.
#pragma once

#include <variant>

#include "element/components/dc_motor.h"
#include "element/components/engine.h"
#include "element/components/first_order.h"
#include "element/components/hydraulic_chamber.h"
#include "element/components/line_maxwell.h"
#include "element/components/maxwell.h"
#include "element/components/pneumatic_chamber.h"
#include "element/components/position_servo.h"
#include "element/components/rate_limiter.h"
#include "element/components/second_order.h"
#include "element/components/series_elastic_drive.h"
#include "element/components/speed_servo.h"
#include "element/components/synchronous_motor.h"
#include "element/components/thermal_mass.h"

namespace gelenk {

struct AnyComponent
    : std::variant<DcMotor, SynchronousMotor, Engine, SpeedServo, PositionServo, SeriesElasticDrive, Maxwell,
                   LineMaxwell, PneumaticChamber, HydraulicChamber, FirstOrder, SecondOrder, RateLimiter, ThermalMass> {
  using variant::variant;
};

}  // namespace gelenk
