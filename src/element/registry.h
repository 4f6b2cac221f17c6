// SPDX-License-Identifier: BSD-3-Clause
// Every kind of element, once. A new one is one new header and one name in the list of its section.
#pragma once

#include <optional>
#include <tuple>
#include <variant>
#include <vector>

#include "element/bushing.h"
#include "element/distance.h"
#include "element/drag.h"
#include "element/drive.h"
#include "element/energy_sensor.h"
#include "element/frame_sensor.h"
#include "element/gear.h"
#include "element/joint_damper.h"
#include "element/joint_spring.h"
#include "element/knife_edge.h"
#include "element/moment.h"
#include "element/motion.h"
#include "element/power.h"
#include "element/rack.h"
#include "element/reaction.h"
#include "element/rolling.h"
#include "element/spring_damper.h"
#include "element/stop.h"
#include "element/wrench.h"

namespace gelenk {

using AnyMotor = std::variant<Drive>;
using AnyForce = std::variant<SpringDamper, Wrench, Bushing, Drag, Moment>;
using AnyConstraint = std::variant<Motion, Gear, Rack, Rolling, KnifeEdge>;
using AnySensor = std::variant<Reaction, FrameSensor, EnergySensor, Distance, Power>;

// What a joint has along each of its coordinates. std::optional: what is there or not.
using JointForces = std::tuple<JointDamper, JointSpring, std::optional<Stop>>;

// What the rest of Gelenk may know of a kind of element without knowing the element.
struct ElementKind {
  std::string_view kind, summary;
  std::span<const Port> ports;
  std::span<const Field> fields;
  std::span<const SignalGroup> outputs;
  bool reads_reaction = false, of_whole = false;  // sensor.h
  bool is_between_bodies = false;                 // constraint.h

  int frames() const { return count(false); }
  int joints() const { return count(true); }

 private:
  int count(bool of_joints) const {
    int n = 0;
    for (const Port& port : ports) n += (port.kind == Port::Kind::joint) == of_joints ? 1 : 0;
    return n;
  }
};

// All kinds of a section, in the order of its list; Any: AnyMotor, AnyForce, ...
template <class Any>
std::span<const ElementKind> element_kinds();
// One of the n-th kind, with its defaults.
template <class Any>
Any make_element(std::size_t n);

template <class Any>
const ElementKind& kind_of(const Any& element) {
  return element_kinds<Any>()[element.index()];
}
// The element itself, for its fields.
template <class Any>
void* data_of(Any& element) {
  return std::visit([](auto& e) -> void* { return &e; }, element);
}
template <class Any>
const void* data_of(const Any& element) {
  return std::visit([](const auto& e) -> const void* { return &e; }, element);
}
template <class Any>
std::span<const SignalGroup> inputs_of(const Any& element);
template <class Any>
int input_count(const Any& element) {
  return count_of(inputs_of(element));
}
// Beyond its fields' ranges.
template <class Any>
std::optional<ElementFault> fault_of(const Any& element, const Coordinate& coordinate);

// Whether a constraint holds positions; else, of those between joints, rates alone, or, of those between bodies, some.
bool holds_positions(const AnyConstraint& constraint);

// kg m2 (kg) that a motor adds to its joint's coordinate.
double inertia_of(const AnyMotor& motor);

// A kind of what a joint has along a coordinate.
struct JointForceKind {
  std::string_view group;            // the mapping that its fields stand in; empty: the joint's own
  std::string_view summary, misfit;  // misfit: what is wrong with a joint that moves and cannot have it
  std::span<const Field> fields;
  bool (*fits)(const JointKind&);
  void* (*there)(JointForces&);  // null: it is not
  const void* (*defaults)();
  void (*give)(JointForces&);                                                      // puts one there, with its defaults
  void (*take)(JointForces&);                                                      // takes it away
  std::optional<ElementFault> (*fault)(const void*, const Coordinate&);            // of one that is there
  std::optional<ElementFault> (*doubt)(const void*, double q, const Coordinate&);  // of a start at q

  const void* in(const JointForces& forces) const;
};
std::span<const JointForceKind> joint_force_kinds();
// Whether there is nothing that acts.
bool is_idle(const JointForces& forces);

}  // namespace gelenk
