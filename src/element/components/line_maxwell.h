// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/component.h"

namespace gelenk {

// A spring and a damper in series between two points. It starts without a force, at any distance.
struct LineMaxwell {
  static constexpr std::string_view kind = "line_maxwell";
  static constexpr std::string_view summary = "a spring and a damper in series between two points (Maxwell element)";
  static constexpr Port ports[] = {{.kind = Port::Kind::point, .name = "from", .text = "One end"},
                                   {.kind = Port::Kind::point, .name = "to", .text = "The other end"}};

  double stiffness = 0, damping = 0;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&LineMaxwell::stiffness>({.name = "stiffness",
                                                                    .unit = "N/m",
                                                                    .text = "stiffness of the spring",
                                                                    .range = Range::positive,
                                                                    .required = true}),
                                    field<&LineMaxwell::damping>({.name = "damping",
                                                                  .unit = "N.s/m",
                                                                  .text = "damping of the damper",
                                                                  .range = Range::positive,
                                                                  .required = true})};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.state({"elongation", "m", "elongation of the spring"}, {"rate - stiffness*elongation/damping"});
    of.pull({"stiffness*elongation"});
    of.value({"loss", "W", "power dissipated by the damper"}, {"(stiffness*elongation)^2/damping"});
  }
};

}  // namespace gelenk
