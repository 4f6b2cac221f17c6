// SPDX-License-Identifier: BSD-3-Clause
// Elements of all types, for code that does not depend on particular types: these are in the registry.h of each
// section.
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <string_view>

#include "element/contacts/contact.h"
#include "element/element.h"
#include "joint/kinds.h"
#include "util/stored.h"

namespace gelenk {

struct AnyMotor;  // an element of a section
struct AnyForce;
struct AnyConstraint;
struct AnyContact;
struct AnySensor;
struct AnyComponent;
struct ComponentEquations;  // of a component (components/component.h)
struct JointForces;         // elements along a coordinate of a joint
struct CutJoint;            // what closes a loop (cut_joint.h)
extern template class Stored<AnyMotor>;
extern template class Stored<AnyForce>;
extern template class Stored<AnyConstraint>;
extern template class Stored<AnyContact>;
extern template class Stored<AnySensor>;
extern template class Stored<AnyComponent>;
extern template class Stored<JointForces>;
extern template class Stored<CutJoint>;

// Description of an element type for code that does not depend on particular elements.
struct ElementKind {
  std::string_view kind, summary;
  std::span<const Port> ports;
  std::span<const Field> fields;
  std::span<const SignalGroup> outputs;
  bool reads_reaction = false, reads_acceleration = false, reads_gravity = false, of_whole = false;  // sensor.h
  bool is_between_bodies = false;                                                                    // constraint.h

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
Stored<Any> make_element(std::size_t n);

// Returns the type of an element.
template <class Any>
const ElementKind& kind_of(const Any& element);
// Address of the element in the variant, to which its fields refer.
template <class Any>
void* data_of(Any& element);
template <class Any>
const void* data_of(const Any& element);
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
// What is probably not intended in its values.
template <class Any>
std::optional<ElementFault> doubt_of(const Any& element);

// Whether a constraint between joints constrains positions, not only their rates; false for constraints between bodies,
// of which single equations may constrain positions.
bool holds_positions(const AnyConstraint& constraint);
// The motion that it is; null: it is another constraint.
struct Motion;
const Motion* find_motion(const AnyConstraint& constraint);

// Whether shapes of bodies that share a joint can touch by this contact, too.
bool includes_joined(const AnyContact& contact);
// The law of a contact.
ContactLaw law_of(const AnyContact& contact);

// Returns the inertia that a motor or a component adds to its joint coordinate [kg m2, kg].
double inertia_of(const AnyMotor& motor);
double inertia_of(const AnyComponent& component);
// The equations of a component.
ComponentEquations equations_of(const AnyComponent& component);

// Description of a type of element along a joint coordinate.
struct JointForceKind {
  std::string_view group;  // key of the mapping with its fields; empty if they are keys of the joint
  std::string_view summary;
  std::string_view misfit;  // why a joint with coordinates cannot have it; completes "a universal joint ..."
  std::span<const Field> fields;
  std::span<const SignalGroup> outputs;  // force and mode (element/joint_forces/coordinate_force.h), or none
  bool (*fits)(const JointKind&);        // whether joints of a type can have it
  bool of_joint = false;                 // it acts on all velocities of the joint, and is among the forces of the first
  void* (*find)(JointForces&);           // address of the element; null if it is not present
  const void* (*defaults)();             // an element with default values
  void (*emplace)(JointForces&);         // adds the element with default values, if it is optional
  void (*erase)(JointForces&);           // removes it or restores the default values
  std::span<const SignalGroup> (*inputs)(const void*);                             // its input signals
  std::optional<ElementFault> (*fault)(const void*, const Coordinate&);            // error in its values
  std::optional<ElementFault> (*doubt)(const void*, double q, const Coordinate&);  // warning about a start at q

  // Address of the element; null if it is not present.
  const void* in(const JointForces& forces) const;
};
// All types of elements along joint coordinates, in the order of JointForces.
std::span<const JointForceKind> joint_force_kinds();
// Whether none of the elements has an effect.
bool is_idle(const JointForces& forces);

// Converts a joint to a CutJoint.
Stored<CutJoint> cut_joint(const AnyJoint& joint);

// Whether constraint equation i constrains a position; otherwise it constrains a velocity only (nonholonomic).
bool holds_position(const CutJoint& joint, int i);

// Number of constraint equations of a constraint between bodies; 0 for joints and rods.
int row_count(const CutJoint& joint);

// Whether the constraint equations are undefined at this pose.
bool is_undefined(const CutJoint& joint, const Pose3& X_FM);
// Whether there are poses at which the constraint equations are undefined.
bool can_be_undefined(const CutJoint& joint);
// The fault of a start at such a pose.
ElementFault undefined_start(const CutJoint& joint);
// The reason why a run ends near such a pose; empty elsewhere.
std::string_view near_undefined(const CutJoint& joint, const Pose3& X_FM);

}  // namespace gelenk
