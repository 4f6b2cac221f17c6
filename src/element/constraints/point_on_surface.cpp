// SPDX-License-Identifier: BSD-3-Clause
#include "element/constraints/point_on_surface.h"

#include <algorithm>
#include <stdexcept>

#include "util/text.h"

namespace gelenk {

std::optional<ElementFault> PointOnSurface::fault(const Coordinate&) const {
  if (!surface.is_given()) return {};
  const std::string found = text::quoted(surface.text());
  const auto names = [&](int variable) { return names_variable(surface, variable); };
  if (!names(0) && !names(1) && !names(2)) return {{"surface", found, "an expression that names x, y or z"}};
  if (has_kinks(surface) || surface.branches() > 0) {
    return {{"surface", found + ", which has kinks (abs, sign, min, max, clip, smoothstep, if, table)",
             "a smooth expression: at a kink of a surface, the velocity or the acceleration would jump"}};
  }
  try {
    (void)prepared();
  } catch (const std::length_error&) {
    return {{"surface", "an expression of " + std::to_string(surface.text().size()) + " characters",
             "a shorter one: its derivatives have too many terms"}};
  }
  return {};
}

}  // namespace gelenk
