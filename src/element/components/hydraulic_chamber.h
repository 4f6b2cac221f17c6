// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/chamber.h"

namespace gelenk {

// A chamber of a hydraulic cylinder with a compressible fluid: p' V / K = Q - V' - leakage (p - p0).
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
        field<&HydraulicChamber::flow>(
            signal_info("flow", "m3/s", "volume flow into the chamber, an expression; an input if not given")),
        field<&HydraulicChamber::area>(area_info),
        field<&HydraulicChamber::volume>(volume_info),
        field<&HydraulicChamber::bulk_modulus>(
            {.name = "bulk_modulus", .unit = "Pa", .text = "bulk modulus of the fluid", .range = Range::positive}),
        field<&HydraulicChamber::leakage>({.name = "leakage",
                                           .unit = "m3/s/Pa",
                                           .text = "flow out of the chamber per pressure above ambient_pressure",
                                           .range = Range::not_negative}),
        field<&HydraulicChamber::ambient_pressure>(ambient_pressure_info)};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.signal({"flow", "m3/s", "volume flow into the chamber"}, flow);
    describe_chamber(of, "bulk_modulus*(flow - area*speed - leakage*(pressure - ambient_pressure))", ambient_pressure);
  }
};

}  // namespace gelenk
