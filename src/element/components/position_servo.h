// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/controller.h"

namespace gelenk {

// A P, PD, PI or PID controller of the coordinate of a joint. With a limit, the integral has anti-windup
// by back-calculation.
struct PositionServo {
  static constexpr std::string_view kind = "position_servo";
  static constexpr std::string_view summary =
      "a P, PD, PI or PID controller of a position, optionally with a limit and anti-windup";
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
        field<&PositionServo::target>(
            signal_info("target", "{q}", "position to reach, an expression; an input if not given")),
        field<&PositionServo::target_speed>(signal_info(
            "target_speed", "{v}", "speed of the target, to which the damping refers, an expression; 0 if not given")),
        field<&PositionServo::feedforward>(signal_info(
            "feedforward", "{f}", "{torque} that is added before the limit, an expression; none if not given")),
        field<&PositionServo::gain>({.name = "gain",
                                     .unit = "{f}/{q}",
                                     .text = "{torque} per error of the position",
                                     .range = Range::not_negative,
                                     .required = true}),
        field<&PositionServo::damping>({.name = "damping",
                                        .unit = "{f}.s/{q}",
                                        .text = "{torque} per error of the speed",
                                        .range = Range::not_negative}),
        field<&PositionServo::reset_time>(reset_time_info),
        field<&PositionServo::limit>(limit_info),
        field<&PositionServo::tracking_time>(tracking_time_info)};
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
