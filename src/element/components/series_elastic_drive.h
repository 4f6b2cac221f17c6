// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/component.h"

namespace gelenk {

// A motor with an inertia of its own that drives the joint through a gear and a spring: its speed and the deflection of
// the spring are states, so that it needs no body. The spring starts relaxed, and the motor at rest.
struct SeriesElasticDrive {
  static constexpr std::string_view kind = "series_elastic_drive";
  static constexpr std::string_view summary = "a motor that drives its joint through a spring";
  static constexpr Port ports[] = {driven_joint};

  Formula torque;
  double stiffness = 0;
  double damping = 0;
  double rotor_inertia = 0;
  double rotor_damping = 0;
  double gear_ratio = 1;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&SeriesElasticDrive::torque>(
            signal_info("torque", "{f}", "{torque} of the motor on its side, an expression; an input if not given")),
        field<&SeriesElasticDrive::stiffness>({.name = "stiffness",
                                               .unit = "{f}/{q}",
                                               .text = "stiffness of the spring, on the side of the joint",
                                               .range = Range::positive,
                                               .required = true}),
        field<&SeriesElasticDrive::damping>({.name = "damping",
                                             .unit = "{f}.s/{q}",
                                             .text = "damping of the spring, on the side of the joint",
                                             .range = Range::not_negative}),
        field<&SeriesElasticDrive::rotor_inertia>({.name = "rotor_inertia",
                                                   .unit = "{J}",
                                                   .text = "rotor inertia on the motor side",
                                                   .range = Range::positive,
                                                   .required = true}),
        field<&SeriesElasticDrive::rotor_damping>({.name = "rotor_damping",
                                                   .unit = "{f}.s/{q}",
                                                   .text = "damping of the motor, on its side",
                                                   .range = Range::not_negative}),
        field<&SeriesElasticDrive::gear_ratio>({.name = "gear_ratio",
                                                .unit = "1",
                                                .text = "travel of the motor per travel of its end of the spring",
                                                .range = Range::not_zero})};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.signal({"torque", "{f}", "{torque} of the motor on its side"}, torque);
    of.state({"deflection", "{q}", "deflection of the spring"}, {"rotor_speed/gear_ratio - speed"});
    of.act({"stiffness*deflection + damping*(rotor_speed/gear_ratio - speed)"});
    of.state({"rotor_speed", "{v}", "speed of the motor on its side"},
             {"(torque - rotor_damping*rotor_speed - {effort}/gear_ratio)/rotor_inertia"});
  }
};

}  // namespace gelenk
