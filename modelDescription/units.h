// SPDX-License-Identifier: BSD-3-Clause
// Units as FMI wants them defined: what they measure, and what people like to read instead.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "scene/unit_system.h"

namespace gelenk {

// What a unit of a scene's variables measures, by the names of Modelica.Units.SI: "Angle"; empty: several things or
// none.
std::string_view quantity(std::string_view unit);

struct DisplayUnit {
  const char* name;
  double factor;  // shown = factor * value
};

// Other units in which to show a unit; the first one is the usual one.
std::span<const DisplayUnit> display_units(std::string_view unit);

// The first of them; empty if there is none.
std::string default_display_unit(std::string_view unit);

}  // namespace gelenk
