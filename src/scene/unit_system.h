// SPDX-License-Identifier: BSD-3-Clause
// Units, and conversion of scenes to natural units. A linkage of the size of a micrometer has the same equations as one
// of a kilometer. Solved in units of length and mass near its own size, each keeps the same number of digits,
// independently of absolute tolerances, round-off limits and products of lengths in a method. The units are powers of
// two, so that conversion is exact.
#pragma once

#include <array>
#include <string_view>

namespace gelenk {

struct Scene;

inline constexpr std::array<const char*, 6> base_units = {"kg", "m", "s", "rad", "A", "K"};

// Exponents of a unit in the order of base_units.
using UnitExponents = std::array<int, 6>;

// Returns the exponents of a unit: "N.m.s/rad" -> kg m2 s-1 rad-1. All factors behind the slash are divisors. Throws
// std::invalid_argument for an unknown unit.
UnitExponents unit_exponents(std::string_view unit);
bool is_unit(std::string_view unit);

struct UnitSystem {
  double length = 1;  // m
  double mass = 1;    // kg

  bool is_si() const { return length == 1 && mass == 1; }
  // Returns the SI value of one unit of this system. unit: spelled as in FMI; empty if dimensionless.
  double size_of(std::string_view unit) const;
};

// Returns units near the length and mass of a scene's bodies, including the parts that were removed; SI units for
// ordinary sizes (1/8 to 8 m, 1/1024 to 1024 kg).
UnitSystem natural_units(const Scene& scene);

struct OmittedSizes;
// Returns the sizes by which natural_units() chooses.
OmittedSizes sizes_of(const Scene& scene);

// Converts a scene from SI to these units. Angles and times remain in rad and s.
void convert(Scene& scene, const UnitSystem& units);

}  // namespace gelenk
