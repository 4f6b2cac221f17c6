// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/controller.h"

namespace gelenk {

// A P or PI controller of the speed of a joint. With a limit, the integral is led back as long as the effort is at it
// (anti-windup by back-calculation).
struct SpeedServo {
  static constexpr std::string_view kind = "speed_servo";
  static constexpr std::string_view summary = "a P or PI controller of a speed, perhaps with a limit and anti-windup";
  static constexpr Port ports[] = {driven_joint};

  Formula target;
  Formula feedforward;
  double gain = 0;
  double reset_time = NAN;
  double limit = NAN;
  double tracking_time = NAN;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&SpeedServo::target>({.name = "target",
                                    .unit = "{v}",
                                    .text = "speed to reach, an expression; an input if not given",
                                    .settable = false,
                                    .variables = variables_along,
                                    .reads = FormulaReads::signals}),
        field<&SpeedServo::feedforward>(
            {.name = "feedforward",
             .unit = "{f}",
             .text = "{torque} that is added before the limit, an expression; none if not given",
             .settable = false,
             .variables = variables_along,
             .reads = FormulaReads::signals}),
        field<&SpeedServo::gain>({.name = "gain",
                                  .unit = "{f}.s/{q}",
                                  .text = "{torque} per error of the speed",
                                  .range = Range::not_negative,
                                  .required = true}),
        field<&SpeedServo::reset_time>(
            {.name = "reset_time",
             .unit = "s",
             .text = "time in which the integral of an error adds as much as its gain; no integral if not given",
             .range = Range::positive,
             .optional = true}),
        field<&SpeedServo::limit>({.name = "limit",
                                   .unit = "{f}",
                                   .text = "limit of the {torque} in both directions",
                                   .range = Range::positive,
                                   .optional = true}),
        field<&SpeedServo::tracking_time>(
            {.name = "tracking_time",
             .unit = "s",
             .text = "time constant that leads the integral back at the limit; reset_time if not given",
             .range = Range::positive,
             .optional = true})};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.signal({"target", "{v}", "speed to reach"}, target);
    describe_controller(of, "target - speed", "{v}", "", *this);
  }
};

}  // namespace gelenk
