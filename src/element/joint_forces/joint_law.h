// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/joint_forces/coordinate_force.h"
#include "util/text.h"

namespace gelenk {

// A force along a joint coordinate as an expression of the coordinate and its speed, such as a cubic spring.
struct JointLaw {
  static constexpr std::string_view group = "law";
  static constexpr std::string_view summary = "a force along the coordinate as an expression of it and of its speed";
  static constexpr std::string_view misfit = "has more than one degree of freedom";  // of a joint with coordinates
  static bool fits(const JointKind& kind) { return kind.stops(); }
  static constexpr FormulaVariable variables[] = {{"phi", "rad"}, {"w", "rad/s"}, {"s", "m"}, {"v", "m/s"}};

  Formula force;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&JointLaw::force>({.name = "effort",
                                 .unit = "{f}",
                                 .text = "smooth expression of {coordinate} and {speed} for the {torque} along it",
                                 .required = true,
                                 .settable = false,
                                 .variables = variables})};
    return all;
  }

  std::optional<ElementFault> fault(const Coordinate&) const {
    if (!force.is_given() || !force.has_kinks()) return {};
    return {{"effort", text::quoted(force.text()) + ", which has kinks (abs, sign, min, max, clip, smoothstep, if)",
             "a smooth expression: kinks are not located yet"}};
  }

  bool is_idle() const { return !force.is_given(); }
  template <class T>
  T effort(const T& q, const T& v, const T*) const {
    if (!force.is_given()) return T(0);
    const T at[] = {q, v, q, v};
    return force.value(at);
  }
};

}  // namespace gelenk
