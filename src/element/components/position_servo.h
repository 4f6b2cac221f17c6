// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/controller.h"

namespace gelenk {

// A P, PD, PI or PID controller of the coordinate of a joint. With a limit, the integral is led back as long as the
// effort is at it (anti-windup by back-calculation).
struct PositionServo {
  static constexpr std::string_view kind = "position_servo";
  static constexpr std::string_view summary =
      "a P, PD, PI or PID controller of a position, perhaps with a limit and anti-windup";
  static constexpr Port ports[] = {driven_joint};

  Formula target, target_speed;
  Formula feedforward;
  double gain = 0;
  double damping = 0;
  double reset_time = NAN;
  double limit = NAN;
  double tracking_time = NAN;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&PositionServo::target>({.name = "target",
                                       .unit = "{q}",
                                       .text = "position to reach, an expression; an input if not given",
                                       .settable = false,
                                       .variables = variables_along,
                                       .reads = FormulaReads::signals}),
        field<&PositionServo::target_speed>(
            {.name = "target_speed",
             .unit = "{v}",
             .text = "speed of the target, to which the damping refers, an expression; 0 if not given",
             .settable = false,
             .variables = variables_along,
             .reads = FormulaReads::signals}),
        field<&PositionServo::feedforward>(
            {.name = "feedforward",
             .unit = "{f}",
             .text = "{torque} that is added before the limit, an expression; none if not given",
             .settable = false,
             .variables = variables_along,
             .reads = FormulaReads::signals}),
        field<&PositionServo::gain>({.name = "gain",
                                     .unit = "{f}/{q}",
                                     .text = "{torque} per error of the position",
                                     .range = Range::not_negative,
                                     .required = true}),
        field<&PositionServo::damping>({.name = "damping",
                                        .unit = "{f}.s/{q}",
                                        .text = "{torque} per error of the speed",
                                        .range = Range::not_negative}),
        field<&PositionServo::reset_time>(
            {.name = "reset_time",
             .unit = "s",
             .text = "time in which the integral of an error adds as much as its gain; no integral if not given",
             .range = Range::positive,
             .optional = true}),
        field<&PositionServo::limit>({.name = "limit",
                                      .unit = "{f}",
                                      .text = "limit of the {torque} in both directions",
                                      .range = Range::positive,
                                      .optional = true}),
        field<&PositionServo::tracking_time>(
            {.name = "tracking_time",
             .unit = "s",
             .text = "time constant that leads the integral back at the limit; reset_time if not given",
             .range = Range::positive,
             .optional = true})};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.signal({"target", "{q}", "position to reach"}, target);
    if (target_speed.is_given()) of.signal({"target_speed", "{v}", "speed of the target"}, target_speed);
    describe_controller(of, "target - position", "{q}",
                        target_speed.is_given() ? " + damping*(target_speed - speed)" : " - damping*speed", *this);
  }
};

}  // namespace gelenk
