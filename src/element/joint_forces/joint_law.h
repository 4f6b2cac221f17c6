// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/joint_forces/coordinate_force.h"

namespace gelenk {

// A force along a joint coordinate as an expression of the coordinate, its speed, the time and inputs, such as a cubic
// spring.
struct JointLaw {
  static constexpr std::string_view group = "law";
  static constexpr std::string_view summary = "a force along the coordinate as an expression of it and of its speed";
  static constexpr std::string_view misfit =
      "has no angles or lengths that it could act on";  // of a joint with coordinates
  static bool fits(const JointKind& kind) { return kind.springs(); }

  Formula force;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&JointLaw::force>({.name = "effort",
                                 .unit = "{f}",
                                 .text = "expression of {coordinate}, {speed}, t and inputs for the {torque} along it",
                                 .required = true,
                                 .settable = false,
                                 .variables = variables_along,
                                 .reads = FormulaReads::signals})};
    return all;
  }

  bool is_idle() const { return !force.is_given(); }
  // Of expressions: the signals that this one names, and what decides on its branches.
  const Formula& formula() const { return force; }
  Formula& formula() { return force; }
  bool reads_speed() const { return names_variable(force, 1) || names_variable(force, 3); }
  template <class T>
  void decide(const T& q, const T& v, const T* signals, T* arguments) const {
    const T at[] = {q, v, q, v};
    force.decide(at, signals, arguments);
  }

  // signals: those that it names, in their order.
  template <class T>
  T effort(const T& q, const T& v, const T* signals) const {
    if (!force.is_given()) return T(0);
    const T at[] = {q, v, q, v};
    return force.value(at, signals);
  }
};

}  // namespace gelenk
