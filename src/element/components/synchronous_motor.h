// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/component.h"

namespace gelenk {

// A permanent magnet synchronous motor in the coordinates d, q of its rotor, with amplitudes of phase quantities. A
// limit of the current is one of either voltage, as in drives that know the induced voltages.
struct SynchronousMotor {
  static constexpr std::string_view kind = "synchronous_motor";
  static constexpr std::string_view summary =
      "a permanent magnet synchronous motor (PMSM) in the coordinates d, q of its rotor";
  static constexpr Port ports[] = {driven_shaft};

  Formula voltage_d, voltage_q;
  double pole_pairs = 1;
  double resistance = 0, inductance_d = 0, inductance_q = 0;
  double flux = 0;
  double current_limit = NAN;
  double gear_ratio = 1;
  double rotor_inertia = 0;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&SynchronousMotor::voltage_d>(
            signal_info("voltage_d", "V", "voltage of the axis d, an expression; an input if not given")),
        field<&SynchronousMotor::voltage_q>(
            signal_info("voltage_q", "V", "voltage of the axis q, an expression; an input if not given")),
        field<&SynchronousMotor::pole_pairs>(
            {.name = "pole_pairs", .unit = "1", .text = "number of pairs of poles", .range = Range::positive}),
        field<&SynchronousMotor::resistance>({.name = "resistance",
                                              .unit = "Ohm",
                                              .text = "resistance of a phase",
                                              .range = Range::positive,
                                              .required = true}),
        field<&SynchronousMotor::inductance_d>({.name = "inductance_d",
                                                .unit = "H",
                                                .text = "inductance along the axis d, of the magnets",
                                                .range = Range::positive,
                                                .required = true}),
        field<&SynchronousMotor::inductance_q>({.name = "inductance_q",
                                                .unit = "H",
                                                .text = "inductance along the axis q",
                                                .range = Range::positive,
                                                .required = true}),
        field<&SynchronousMotor::flux>({.name = "flux",
                                        .unit = "V.s",
                                        .text = "flux of the magnets that a phase sees",
                                        .range = Range::not_negative,
                                        .required = true}),
        field<&SynchronousMotor::current_limit>({.name = "current_limit",
                                                 .unit = "A",
                                                 .text = "limit of either current in both directions",
                                                 .range = Range::positive,
                                                 .optional = true}),
        field<&SynchronousMotor::gear_ratio>(gear_ratio_info),
        field<&SynchronousMotor::rotor_inertia>(rotor_inertia_info)};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.signal({"voltage_d", "V", "voltage of the axis d"}, voltage_d);
    of.signal({"voltage_q", "V", "voltage of the axis q"}, voltage_q);
    of.value({"electrical_speed", "rad/s", "electrical speed"}, {"pole_pairs*gear_ratio*speed"});
    of.value({"emf_d", "V", "induced voltage of the axis d"}, {"-electrical_speed*inductance_q*iq"});
    of.value({"emf_q", "V", "induced voltage of the axis q"}, {"electrical_speed*(inductance_d*id + flux)"});
    const bool is_limited = is_given(current_limit);
    of.value({"applied_d", "V", "voltage at the winding of the axis d"},
             {is_limited ? "clip(voltage_d, emf_d - resistance*current_limit, emf_d + resistance*current_limit)"
                         : "voltage_d"});
    of.value({"applied_q", "V", "voltage at the winding of the axis q"},
             {is_limited ? "clip(voltage_q, emf_q - resistance*current_limit, emf_q + resistance*current_limit)"
                         : "voltage_q"});
    of.state({"id", "A", "current of the axis d"}, {"(applied_d - emf_d - resistance*id)/inductance_d"});
    of.state({"iq", "A", "current of the axis q"}, {"(applied_q - emf_q - resistance*iq)/inductance_q"});
    of.act({"1.5*gear_ratio*pole_pairs*(flux*iq + (inductance_d - inductance_q)*id*iq)"});
    of.value({"power", "W", "electrical power taken"}, {"1.5*(applied_d*id + applied_q*iq)"});
    of.value({"loss", "W", "resistive loss"}, {"1.5*resistance*(id^2 + iq^2)"});
  }
  double inertia() const { return reflected_inertia(gear_ratio, rotor_inertia); }
};

}  // namespace gelenk
