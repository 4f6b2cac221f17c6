// SPDX-License-Identifier: BSD-3-Clause
// Units, and scenes in units of their own size. A linkage of a micrometre and one of a kilometre are the same
// equations: solved in units of length and mass near their own, both keep the same digits, whatever tolerances, limits
// of rounding and products of lengths a method has. The units are powers of two, so changing to them and back rounds
// nothing.
#pragma once

#include <array>
#include <string_view>

namespace gelenk {

struct Scene;

inline constexpr std::array<const char*, 4> base_units = {"kg", "m", "s", "rad"};

// Exponents in the order of base_units.
using UnitExponents = std::array<int, 4>;

// "N.m.s/rad" -> kg m2 s-1 rad-1. All that follows the slash divides. Throws std::invalid_argument.
UnitExponents unit_exponents(std::string_view unit);

struct UnitSystem {
  double length = 1;  // m
  double mass = 1;    // kg

  bool is_si() const { return length == 1 && mass == 1; }
  // The SI value of 1 in this system; unit: as FMI spells it, or none.
  double size_of(std::string_view unit) const;
};

// Units near the size and the mass of a scene's bodies; SI for what engineers usually build (0.1 to 10 m, 1 g to 1 t).
// What has been left out of it counts.
UnitSystem natural_units(const Scene& scene);

struct LeftOut;
// The sizes by which these are chosen.
LeftOut sizes_of(const Scene& scene);

// Takes the numbers of a scene that is in SI to these units. Angles and times stay.
void convert(Scene& scene, const UnitSystem& units);

}  // namespace gelenk
