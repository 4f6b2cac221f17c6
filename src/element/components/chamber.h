// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/component.h"

namespace gelenk {

// What the chambers of cylinders share. One on the other side of the piston has a negative area.
inline constexpr FieldInfo area_info = {
    .name = "area",
    .unit = "m2",
    .text = "area of the piston; negative where the chamber becomes smaller as joint {joint} moves",
    .range = Range::not_zero,
    .required = true};
inline constexpr FieldInfo volume_info = {
    .name = "volume", .unit = "m3", .text = "volume at the coordinate 0", .range = Range::positive, .required = true};
inline constexpr FieldInfo ambient_pressure_info = {
    .name = "ambient_pressure", .unit = "Pa", .text = "pressure on the other side", .range = Range::not_negative};

// rate: that of the pressure, times the volume.
inline void describe_chamber(ComponentEquations& of, std::string_view rate, double ambient_pressure) {
  of.value({"chamber_volume", "m3", "volume of the chamber"}, {"volume + area*position"});
  // The root is undefined beyond the end of the chamber: the run ends there, with a message.
  of.state({"pressure", "Pa", "pressure"}, {"(", rate, ")/sqrt(chamber_volume)^2"}, ambient_pressure, 1e5);
  of.act({"(pressure - ambient_pressure)*area"});
}

}  // namespace gelenk
