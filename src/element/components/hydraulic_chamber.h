// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/component.h"

namespace gelenk {

// A chamber of a hydraulic cylinder with a compressible fluid: p' V / K = Q - V' - leakage (p - p0). A chamber on the
// other side of the piston has a negative area.
struct HydraulicChamber {
  static constexpr std::string_view kind = "hydraulic_chamber";
  static constexpr std::string_view summary = "a chamber of a hydraulic cylinder, filled by a volume flow";
  static constexpr Port ports[] = {driven_slide};

  Formula flow;
  double area = 0;
  double volume = 0;
  double bulk_modulus = 1.4e9;
  double leakage = 0;
  double ambient_pressure = 101325;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&HydraulicChamber::flow>({.name = "flow",
                                        .unit = "m3/s",
                                        .text = "volume flow into the chamber, an expression; an input if not given",
                                        .settable = false,
                                        .variables = variables_along,
                                        .reads = FormulaReads::signals}),
        field<&HydraulicChamber::area>(
            {.name = "area",
             .unit = "m2",
             .text = "area of the piston; negative where the chamber becomes smaller as joint {joint} moves",
             .range = Range::not_zero,
             .required = true}),
        field<&HydraulicChamber::volume>({.name = "volume",
                                          .unit = "m3",
                                          .text = "volume at the coordinate 0",
                                          .range = Range::positive,
                                          .required = true}),
        field<&HydraulicChamber::bulk_modulus>(
            {.name = "bulk_modulus", .unit = "Pa", .text = "bulk modulus of the fluid", .range = Range::positive}),
        field<&HydraulicChamber::leakage>({.name = "leakage",
                                           .unit = "m3/s/Pa",
                                           .text = "flow out of the chamber per pressure above ambient_pressure",
                                           .range = Range::not_negative}),
        field<&HydraulicChamber::ambient_pressure>({.name = "ambient_pressure",
                                                    .unit = "Pa",
                                                    .text = "pressure on the other side",
                                                    .range = Range::not_negative})};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.signal({"flow", "m3/s", "volume flow into the chamber"}, flow);
    of.value({"chamber_volume", "m3", "volume of the chamber"}, {"volume + area*position"});
    // Of no volume there is no root: the run ends, with a message.
    of.state({"pressure", "Pa", "pressure"},
             {"bulk_modulus*(flow - area*speed - leakage*(pressure - ambient_pressure))/sqrt(chamber_volume)^2"},
             ambient_pressure, 1e5);
    of.act({"(pressure - ambient_pressure)*area"});
  }
};

}  // namespace gelenk
