// SPDX-License-Identifier: BSD-3-Clause
// Losses of gears and racks: of the power that enters the mesh, the part `efficiency` leaves it in the usual direction,
// and `backdriving` in the other one. They are friction of the joint that usually drives, proportional to the force of
// the mesh on it. Equal friction in both directions means backdriving = 2 - 1 / efficiency, which is the default (NaN);
// at 0 or less the mesh is self-locking.
#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "element/element.h"
#include "util/text.h"

namespace gelenk {

// The friction per force that the mesh exerts on the joint, if that joint drives, and if it is driven.
inline std::array<double, 2> losses_of_mesh(double efficiency, double backdriving) {
  const double driving = 1 / efficiency - 1;
  return {driving, std::isnan(backdriving) ? driving : 1 - backdriving};
}

inline std::optional<ElementFault> fault_of_mesh(double efficiency, double backdriving) {
  if (efficiency > 1) return {{"efficiency", text::number(efficiency), "1 or less"}};
  if (backdriving > 1) return {{"backdriving", text::number(backdriving), "1 or less"}};
  return {};
}

// An element with losses also has `lossy_joint`: which of its joints has this friction.
template <class C>
concept LosesPower = requires(const C& c) {
  c.losses();
  C::lossy_joint;
};

}  // namespace gelenk
