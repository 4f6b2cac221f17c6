// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "kinematics/named_reading.h"
#include "mechanism/mechanism.h"
#include "scene/scene.h"

namespace gelenk {

// The component of a group of a sensor's outputs, for expressions.
std::shared_ptr<const NamedReading> sensor_reading(const Scene& scene, const ReducedScene& reduced,
                                                   const Sensor& sensor, int group, int component);

}  // namespace gelenk
