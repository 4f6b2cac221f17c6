// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/component.h"

namespace gelenk {

// A body with one temperature, warmed by losses and cooled by its surroundings: C T' = heat - (T - T0) / R.
struct ThermalMass {
  static constexpr std::string_view kind = "thermal_mass";
  static constexpr std::string_view summary = "a heat capacity that is warmed by losses and cooled by its surroundings";
  static constexpr std::span<const Port> ports = {};

  Formula heat;
  double capacity = 0;
  double resistance = NAN;
  double ambient_temperature = 293.15;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&ThermalMass::heat>(
            free_signal_info("heat", "W", "heat flow into it, an expression; an input if not given")),
        field<&ThermalMass::capacity>(
            {.name = "capacity", .unit = "J/K", .text = "heat capacity", .range = Range::positive, .required = true}),
        field<&ThermalMass::resistance>({.name = "resistance",
                                         .unit = "K/W",
                                         .text = "thermal resistance to the surroundings; none is lost if not given",
                                         .range = Range::positive,
                                         .optional = true}),
        field<&ThermalMass::ambient_temperature>({.name = "ambient_temperature",
                                                  .unit = "K",
                                                  .text = "temperature of the surroundings",
                                                  .range = Range::not_negative})};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.signal({"heat", "W", "heat flow into it"}, heat);
    of.state({"temperature", "K", "temperature"},
             {"(heat", is_given(resistance) ? " - (temperature - ambient_temperature)/resistance" : "", ")/capacity"},
             ambient_temperature, 100);
  }
};

}  // namespace gelenk
