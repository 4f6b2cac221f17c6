// SPDX-License-Identifier: BSD-3-Clause
// The list of all element types. A new type requires a header and its name in the list of its section.
#pragma once

#include <optional>
#include <tuple>
#include <variant>

#include "element/bushing.h"
#include "element/distance.h"
#include "element/drag.h"
#include "element/drive.h"
#include "element/energy_sensor.h"
#include "element/frame_sensor.h"
#include "element/gear.h"
#include "element/joint_damper.h"
#include "element/joint_friction.h"
#include "element/joint_limit.h"
#include "element/joint_one_way.h"
#include "element/joint_spring.h"
#include "element/kinds.h"
#include "element/knife_edge.h"
#include "element/moment.h"
#include "element/motion.h"
#include "element/power.h"
#include "element/rack.h"
#include "element/reaction.h"
#include "element/rolling.h"
#include "element/spring_damper.h"
#include "element/stop.h"
#include "element/surface_contact.h"
#include "element/tire.h"
#include "element/wrench.h"

namespace gelenk {

struct AnyMotor : std::variant<Drive> {
  using variant::variant;
};
struct AnyForce : std::variant<SpringDamper, Wrench, Bushing, Drag, Moment, Tire> {
  using variant::variant;
};
struct AnyConstraint : std::variant<Motion, Gear, Rack, Rolling, KnifeEdge> {
  using variant::variant;
};
struct AnyContact : std::variant<SurfaceContact> {
  using variant::variant;
};
struct AnySensor : std::variant<Reaction, FrameSensor, EnergySensor, Distance, Power> {
  using variant::variant;
};

// Elements along each coordinate of a joint; those in std::optional need not be present.
struct JointForces : std::tuple<JointDamper, JointSpring, std::optional<Stop>, std::optional<JointFriction>,
                                std::optional<JointLimit>, std::optional<JointOneWay>> {
  const tuple& all() const { return *this; }
};

}  // namespace gelenk
