// SPDX-License-Identifier: BSD-3-Clause
// Losses of gears and racks: of the power that enters the mesh, the part `efficiency` leaves it if the joint drives of
// which they are friction, and `backdriving` if it is driven. By default (NaN), friction is equal in both directions,
// backdriving = 2 - 1 / efficiency; at 0 or less the mesh is self-locking.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "element/element.h"
#include "util/text.h"

namespace gelenk {

// The friction per force that the mesh exerts on the joint, if that joint drives, and if it is driven.
inline std::array<double, 2> losses_of_mesh(double efficiency, double backdriving) {
  return {1 / efficiency - 1, std::isnan(backdriving) ? 1 / efficiency - 1 : 1 - backdriving};
}

constexpr FieldInfo efficiency_info(std::string_view text) {
  return {.name = "efficiency", .unit = "1", .text = text, .range = Range::positive, .settable = false};
}
constexpr FieldInfo backdriving_info(std::string_view text) {
  return {.name = "backdriving", .unit = "1", .text = text, .optional = true, .settable = false};
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
