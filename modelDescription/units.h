// SPDX-License-Identifier: BSD-3-Clause
// Unit definitions of FMI: physical quantities and display units.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "scene/unit_system.h"

namespace gelenk {

// The physical quantity of a unit, by its name in Modelica.Units.SI ("Angle"); empty if it is ambiguous or there is
// none.
std::string_view quantity(std::string_view unit);

struct DisplayUnit {
  const char* name;
  double factor;  // shown = factor * value
};

// Alternative units in which values may be displayed, the default first.
std::span<const DisplayUnit> display_units(std::string_view unit);

// The first display unit; empty if there is none.
std::string default_display_unit(std::string_view unit);

}  // namespace gelenk
