// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/chamber.h"

namespace gelenk {

// A chamber of a pneumatic cylinder with an ideal gas of constant temperature of supply and polytropic changes:
// p' V = n (R T m' - p V').
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
        field<&PneumaticChamber::flow>(
            signal_info("flow", "kg/s", "mass flow into the chamber, an expression; an input if not given")),
        field<&PneumaticChamber::area>(area_info),
        field<&PneumaticChamber::volume>(volume_info),
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
        field<&PneumaticChamber::ambient_pressure>(ambient_pressure_info)};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.signal({"flow", "kg/s", "mass flow into the chamber"}, flow);
    describe_chamber(of, "exponent*(gas_constant*temperature*flow - pressure*area*speed)", ambient_pressure);
  }
};

}  // namespace gelenk
