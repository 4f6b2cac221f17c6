// SPDX-License-Identifier: BSD-3-Clause
// The list of all element types. A new type requires a header and its name in the list of its section.
#pragma once

#include <algorithm>
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
#include "element/joint_friction.h"
#include "element/joint_limit.h"
#include "element/joint_one_way.h"
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
#include "element/surface_contact.h"
#include "element/tire.h"
#include "element/wrench.h"

namespace gelenk {

using AnyMotor = std::variant<Drive>;
using AnyForce = std::variant<SpringDamper, Wrench, Bushing, Drag, Moment, Tire>;
using AnyConstraint = std::variant<Motion, Gear, Rack, Rolling, KnifeEdge>;
using AnyContact = std::variant<SurfaceContact>;
using AnySensor = std::variant<Reaction, FrameSensor, EnergySensor, Distance, Power>;

// Elements along each coordinate of a joint; those in std::optional need not be present.
using JointForces = std::tuple<JointDamper, JointSpring, std::optional<Stop>, std::optional<JointFriction>,
                               std::optional<JointLimit>, std::optional<JointOneWay>>;

// Description of an element type for code that does not depend on particular elements.
struct ElementKind {
  std::string_view kind, summary;
  std::span<const Port> ports;
  std::span<const Field> fields;
  std::span<const SignalGroup> outputs;
  bool reads_reaction = false, of_whole = false;  // sensor.h
  bool is_between_bodies = false;                 // constraint.h

  // Number of ports that are frames, points or bodies, and of those that are joints.
  int frames() const {
    return static_cast<int>(std::ranges::count_if(ports, [](const Port& port) { return port.is_frame(); }));
  }
  int joints() const { return static_cast<int>(std::ranges::count(ports, Port::Kind::joint, &Port::kind)); }
};

// All types of a section, in the order of its list; Any: AnyMotor, AnyForce, ...
template <class Any>
std::span<const ElementKind> element_kinds();
// Makes an element of the n-th type, with default values. Throws std::out_of_range if there is no such type.
template <class Any>
Any make_element(std::size_t n);

// Returns the type of an element.
template <class Any>
const ElementKind& kind_of(const Any& element) {
  return element_kinds<Any>()[element.index()];
}
// Address of the element in the variant, to which its fields refer.
template <class Any>
void* data_of(Any& element) {
  return std::visit([](auto& e) -> void* { return &e; }, element);
}
template <class Any>
const void* data_of(const Any& element) {
  return std::visit([](const auto& e) -> const void* { return &e; }, element);
}
// Input signals of an element, and their number.
template <class Any>
std::span<const SignalGroup> inputs_of(const Any& element);
template <class Any>
int input_count(const Any& element) {
  return count_of(inputs_of(element));
}
// Returns the error in the values of an element that the ranges of its fields do not cover, if there is one.
template <class Any>
std::optional<ElementFault> fault_of(const Any& element, const Coordinate& coordinate);

// Whether a constraint between joints constrains positions, not only their rates; false for constraints between bodies,
// of which single equations may constrain positions.
bool holds_positions(const AnyConstraint& constraint);

// Whether shapes of bodies that share a joint can touch by this contact, too.
bool includes_joined(const AnyContact& contact);
// The law of a contact.
ContactLaw law_of(const AnyContact& contact);

// Returns the inertia that a motor adds to its joint coordinate [kg m2, kg].
double inertia_of(const AnyMotor& motor);

// Description of a type of element along a joint coordinate.
struct JointForceKind {
  std::string_view group;  // key of the mapping with its fields; empty if they are keys of the joint
  std::string_view summary;
  std::string_view misfit;  // why a joint with coordinates cannot have it; completes "a universal joint ..."
  std::span<const Field> fields;
  std::span<const SignalGroup> outputs;                 // force and mode (element/coordinate_force.h), or none
  bool (*fits)(const JointKind&);                       // whether joints of a type can have it
  void* (*find)(JointForces&);                          // address of the element; null if it is not present
  const void* (*defaults)();                            // an element with default values
  void (*emplace)(JointForces&);                        // adds the element with default values, if it is optional
  void (*erase)(JointForces&);                          // removes it or restores the default values
  std::span<const SignalGroup> (*inputs)(const void*);  // its input signals
  std::optional<ElementFault> (*fault)(const void*, const Coordinate&);            // error in its values
  std::optional<ElementFault> (*doubt)(const void*, double q, const Coordinate&);  // warning about a start at q

  // Address of the element; null if it is not present.
  const void* in(const JointForces& forces) const;
};
// All types of elements along joint coordinates, in the order of JointForces.
std::span<const JointForceKind> joint_force_kinds();
// Whether none of the elements has an effect.
bool is_idle(const JointForces& forces);

}  // namespace gelenk
