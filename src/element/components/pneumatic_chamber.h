// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/component.h"

namespace gelenk {

// A chamber of a pneumatic cylinder with an ideal gas of constant temperature of supply and polytropic changes:
// p' V = n (R T m' - p V'). A chamber on the other side of the piston has a negative area.
struct PneumaticChamber {
  static constexpr std::string_view kind = "pneumatic_chamber";
  static constexpr std::string_view summary = "a chamber of a pneumatic cylinder, filled by a mass flow";
  static constexpr Port ports[] = {driven_slide};

  Formula flow;
  double area = 0;
  double volume = 0;
  double exponent = 1.4;
  double gas_constant = 287.05;
  double temperature = 293.15;
  double ambient_pressure = 101325;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&PneumaticChamber::flow>({.name = "flow",
                                        .unit = "kg/s",
                                        .text = "mass flow into the chamber, an expression; an input if not given",
                                        .settable = false,
                                        .variables = variables_along,
                                        .reads = FormulaReads::signals}),
        field<&PneumaticChamber::area>(
            {.name = "area",
             .unit = "m2",
             .text = "area of the piston; negative where the chamber becomes smaller as joint {joint} moves",
             .range = Range::not_zero,
             .required = true}),
        field<&PneumaticChamber::volume>({.name = "volume",
                                          .unit = "m3",
                                          .text = "volume at the coordinate 0",
                                          .range = Range::positive,
                                          .required = true}),
        field<&PneumaticChamber::exponent>({.name = "exponent",
                                            .unit = "1",
                                            .text = "polytropic exponent: 1 isothermal, 1.4 adiabatic for air",
                                            .range = Range::positive}),
        field<&PneumaticChamber::gas_constant>(
            {.name = "gas_constant", .unit = "J/kg/K", .text = "specific gas constant", .range = Range::positive}),
        field<&PneumaticChamber::temperature>({.name = "temperature",
                                               .unit = "K",
                                               .text = "temperature of the gas that flows",
                                               .range = Range::positive}),
        field<&PneumaticChamber::ambient_pressure>({.name = "ambient_pressure",
                                                    .unit = "Pa",
                                                    .text = "pressure on the other side",
                                                    .range = Range::not_negative})};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.signal({"flow", "kg/s", "mass flow into the chamber"}, flow);
    of.value({"chamber_volume", "m3", "volume of the chamber"}, {"volume + area*position"});
    // Of no volume there is no root: the run ends, with a message.
    of.state({"pressure", "Pa", "pressure"},
             {"exponent*(gas_constant*temperature*flow - pressure*area*speed)/sqrt(chamber_volume)^2"},
             ambient_pressure, 1e5);
    of.act({"(pressure - ambient_pressure)*area"});
  }
};

}  // namespace gelenk
