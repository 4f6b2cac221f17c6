// SPDX-License-Identifier: BSD-3-Clause
#include "scene/natural_time.h"

#include <algorithm>
#include <cmath>

#include "joint/kinds.h"
#include "scene/element_numbers.h"

namespace gelenk {
namespace {

constexpr double max_ordinary_time = 16;  // s; a time between the reciprocal and this is replaced by 1 s

// Squared characteristic frequencies [1/s2] of springs and constant forces: a stiffness [N m^n/rad] or a force [N m^n]
// divided by the units of mass and length.
struct Rates {
  double softest = 0;  // smallest one of springs; 0 if there is none
  double largest = 0;  // largest one of constant forces; 0 if there is none

  void add(std::span<const Field> fields, const void* element, const Coordinate& coordinate, const UnitSystem& units) {
    each_number(fields, element, [&](const Number& x) {
      const UnitExponents unit = unit_exponents(x.field->unit.empty() ? "1" : x.unit(coordinate));
      const auto& [kg, m, s, rad, ampere, kelvin] = unit;
      if (kg != 1 || s != -2 || *x.value == 0) return;
      const double rate = std::abs(*x.value) / (units.mass * std::pow(units.length, m));
      if (m == 0 || rad == -1) {
        softest = softest > 0 ? std::min(softest, rate) : rate;
      } else {
        largest = std::max(largest, rate);
      }
    });
  }
};

Rates rates_of(const Scene& scene, const UnitSystem& units) {
  Rates out;
  for (const Joint& joint : scene.joints) {
    const JointKind& kind = *find_joint_kind(joint.type);
    for (std::size_t i = 0; i < joint.along.size(); ++i) {
      for (const JointForceKind& force : joint_force_kinds()) {
        const void* there = force.group.empty() ? force.in(*joint.along[i]) : nullptr;
        if (there != nullptr) out.add(force.fields, there, coordinate_of(kind, static_cast<int>(i)), units);
      }
    }
  }
  for (const Force& force : scene.forces) out.add(kind_of(*force.is).fields, data_of(*force.is), {}, units);
  return out;
}

}  // namespace

double natural_time(const Scene& scene, const UnitSystem& units) {
  double rate = scene.gravity.norm() / units.length;  // squared frequency [1/s2]
  const Rates rates = rates_of(scene, units);
  if (!(rate > 0)) rate = rates.softest;
  if (!(rate > 0)) rate = rates.largest;
  const double time = 1 / std::sqrt(rate);
  const bool ordinary = !std::isfinite(time) || (time >= 1 / max_ordinary_time && time <= max_ordinary_time);
  return ordinary ? 1 : std::exp2(std::round(std::log2(time)));
}

}  // namespace gelenk
