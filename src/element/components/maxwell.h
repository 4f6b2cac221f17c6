// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/component.h"

namespace gelenk {

// A spring and a damper in series along a coordinate (Maxwell element). It starts without a force.
struct Maxwell {
  static constexpr std::string_view kind = "maxwell";
  static constexpr std::string_view summary = "a spring and a damper in series along a coordinate (Maxwell element)";
  static constexpr Port ports[] = {driven_joint};

  double stiffness = 0, damping = 0;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&Maxwell::stiffness>({.name = "stiffness",
                                                                .unit = "{f}/{q}",
                                                                .text = "stiffness of the spring",
                                                                .range = Range::positive,
                                                                .required = true}),
                                    field<&Maxwell::damping>({.name = "damping",
                                                              .unit = "{f}.s/{q}",
                                                              .text = "damping of the damper",
                                                              .range = Range::positive,
                                                              .required = true})};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.state({"elongation", "{q}", "elongation of the spring"}, {"speed - stiffness*elongation/damping"});
    of.act({"-stiffness*elongation"});
    of.value({"loss", "W", "power dissipated by the damper"}, {"(stiffness*elongation)^2/damping"});
  }
};

}  // namespace gelenk
