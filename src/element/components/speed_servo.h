// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/controller.h"

namespace gelenk {

// A P or PI controller of the speed of a joint. With a limit, the integral has anti-windup by
// back-calculation.
struct SpeedServo {
  static constexpr std::string_view kind = "speed_servo";
  static constexpr std::string_view summary =
      "a P or PI controller of a speed, optionally with a limit and anti-windup";
  static constexpr Port ports[] = {driven_joint};

  Formula target;
  Formula feedforward;
  double gain = 0;
  double reset_time = NAN;
  double limit = NAN;
  double tracking_time = NAN;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&SpeedServo::target>(
            signal_info("target", "{v}", "speed to reach, an expression; an input if not given")),
        field<&SpeedServo::feedforward>(signal_info(
            "feedforward", "{f}", "{torque} that is added before the limit, an expression; none if not given")),
        field<&SpeedServo::gain>({.name = "gain",
                                  .unit = "{f}.s/{q}",
                                  .text = "{torque} per error of the speed",
                                  .range = Range::not_negative,
                                  .required = true}),
        field<&SpeedServo::reset_time>(reset_time_info),
        field<&SpeedServo::limit>(limit_info),
        field<&SpeedServo::tracking_time>(tracking_time_info)};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.signal({"target", "{v}", "speed to reach"}, target);
    describe_controller(of, "target - speed", "{v}", "", *this);
  }
};

}  // namespace gelenk
