// SPDX-License-Identifier: BSD-3-Clause
// Components: motors with circuits, controllers, filters, chambers. A component is a header with fields and equations
// as texts, from which scene/component_parts.h makes states, named expressions and inputs of the scene, and a force
// along a joint. Besides what elements share (element/element.h) it has
//
//   ports         none, a joint with one coordinate, or two points
//   describe(of)  enters its equations in ComponentEquations
//   inertia()     what it adds to that of its joint's coordinate [kg m2, kg]; optional
//
// Texts are expressions in SI units. They name the fields, signals, states and values of the component, and `position`
// and `speed` of its joint, or the distance `length` of its points and its `rate`. Which equations there are may depend
// on which optional fields are given, not on numbers, since these are parameters.
#pragma once

#include <cmath>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "element/gearing.h"
#include "element/joint_forces/coordinate_force.h"
#include "element/kinds.h"

namespace gelenk {

struct ComponentEquations {
  // What all quantities have; unit: as of a field.
  struct Quantity {
    std::string_view name, unit, text;
  };
  struct State : Quantity {
    std::string rate;
    double start = 0;
    double nominal = 0;  // 0: 1 in the unit
  };
  struct Value : Quantity {
    std::string value;
    bool is_given = false;  // by a field, as an expression of the user's
  };
  std::vector<Quantity> inputs;
  std::vector<State> states;
  std::vector<Value> values;
  std::string_view effort;   // along the joint; empty: none
  std::string_view tension;  // between the points; empty: none

  // Several texts one after the other.
  using Texts = std::initializer_list<std::string_view>;
  // A signal that a field of this name gives as an expression, or else an input.
  void signal(const Quantity& quantity, const Formula& given);
  void state(const Quantity& quantity, Texts rate, double start = 0, double nominal = 0);
  void value(const Quantity& quantity, Texts value);
  // The effort on the joint, also an output.
  void act(Texts value);
  // The force that pulls the points together, also an output.
  void pull(Texts value);
};
// As one text.
std::string joined(ComponentEquations::Texts texts);

// Of what a component between two points consists beside its equations: a sensor of their distance, and a force between
// them, of which the only field is the expression of its tension.
Stored<AnySensor> sensor_of_length();
Stored<AnyForce> force_along_line();
inline constexpr std::string_view length_output = "d", rate_output = "v";  // of the sensor

inline bool is_given(double optional) { return std::isfinite(optional); }

// A field with a signal: an expression, also of the coordinate and the speed of the joint.
constexpr FieldInfo signal_info(std::string_view name, std::string_view unit, std::string_view text) {
  return {.name = name,
          .unit = unit,
          .text = text,
          .settable = false,
          .variables = variables_along,
          .reads = FormulaReads::forces};
}
// The same of a component without a joint.
constexpr FieldInfo free_signal_info(std::string_view name, std::string_view unit, std::string_view text) {
  FieldInfo out = signal_info(name, unit, text);
  out.variables = {};
  return out;
}

// Joints of components that fit one type of coordinate only; others have a driven_joint.
inline constexpr Port driven_slide = {
    .kind = Port::Kind::joint, .name = "joint", .text = "Prismatic joint", .fits = [](const JointKind& kind) {
      return kind.nq == 1 && kind.nv == 1 && kind.q[0].unit == "m";
    }};
inline constexpr Port driven_shaft = {
    .kind = Port::Kind::joint, .name = "joint", .text = "Revolute joint", .fits = [](const JointKind& kind) {
      return kind.nq == 1 && kind.nv == 1 && kind.q[0].unit == "rad";
    }};

}  // namespace gelenk
