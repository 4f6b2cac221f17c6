// SPDX-License-Identifier: BSD-3-Clause
// Units as FMI wants them defined: exponents of the SI base units, and what people like to read instead.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

namespace gelenk {

inline constexpr std::array<const char*, 4> base_units = {"kg", "m", "s", "rad"};

// Exponents in the order of base_units.
using UnitExponents = std::array<int, 4>;

// "N.m.s/rad" -> kg m2 s-1 rad-1. All that follows the slash divides. Throws std::invalid_argument.
UnitExponents unit_exponents(std::string_view unit);

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
