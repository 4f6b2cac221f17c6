// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/component.h"

namespace gelenk {

// A DC motor with permanent magnets: L i' = u - R i - k w, torque k i, both on the side of the motor. A limit of the
// current is one of the voltage, as in drives that know the back-EMF: it is never more than the largest current needs.
struct DcMotor {
  static constexpr std::string_view kind = "dc_motor";
  static constexpr std::string_view summary = "a DC motor with inductance, back-EMF and an optional current limit";
  static constexpr Port ports[] = {driven_joint};

  Formula voltage;
  double resistance = 0, inductance = 0;
  double constant = 0;
  double current_limit = NAN;
  double gear_ratio = 1;
  double rotor_inertia = 0;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&DcMotor::voltage>(signal_info("voltage", "V", "voltage, an expression; an input if not given")),
        field<&DcMotor::resistance>({.name = "resistance",
                                     .unit = "Ohm",
                                     .text = "resistance of the armature",
                                     .range = Range::positive,
                                     .required = true}),
        field<&DcMotor::inductance>({.name = "inductance",
                                     .unit = "H",
                                     .text = "inductance of the armature",
                                     .range = Range::positive,
                                     .required = true}),
        field<&DcMotor::constant>({.name = "constant",
                                   .unit = "{f}/A",
                                   .text = "{torque} per current, and back-EMF per speed, of the motor",
                                   .range = Range::positive,
                                   .required = true}),
        field<&DcMotor::current_limit>({.name = "current_limit",
                                        .unit = "A",
                                        .text = "limit of the current in both directions",
                                        .range = Range::positive,
                                        .optional = true}),
        field<&DcMotor::gear_ratio>(gear_ratio_info),
        field<&DcMotor::rotor_inertia>(rotor_inertia_info)};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.signal({"voltage", "V", "voltage"}, voltage);
    of.value({"emf", "V", "back-EMF"}, {"constant*gear_ratio*speed"});
    of.value({"applied", "V", "voltage at the armature"},
             {is_given(current_limit) ? "clip(voltage, emf - resistance*current_limit, emf + resistance*current_limit)"
                                      : "voltage"});
    of.state({"i", "A", "current"}, {"(applied - emf - resistance*i)/inductance"});
    of.act({"gear_ratio*constant*i"});
    of.value({"power", "W", "electrical power taken"}, {"applied*i"});
    of.value({"loss", "W", "resistive loss"}, {"resistance*i^2"});
  }
  double inertia() const { return reflected_inertia(gear_ratio, rotor_inertia); }
};

}  // namespace gelenk
