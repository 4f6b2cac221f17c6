// SPDX-License-Identifier: BSD-3-Clause
// Losses of gears and racks: of the power that enters the mesh, the part `efficiency` leaves it if the joint drives of
// which they are friction, and `backdriving` if it is driven. By default, friction is equal in both directions,
// backdriving = 2 - 1 / efficiency; at 0 or less the mesh is self-locking. Both may be expressions of the size of the
// speed of that joint and of signals.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "element/element.h"
#include "util/text.h"

namespace gelenk {

struct MeshLosses {
  static constexpr FormulaVariable of_speed[] = {{"w", "rad/s", true}};

  Formula efficiency, backdriving;

  static constexpr FieldInfo efficiency_info(std::string_view text) {
    return {.name = "efficiency",
            .unit = "1",
            .text = text,
            .range = Range::fraction,
            .settable = false,
            .variables = of_speed,
            .reads = FormulaReads::signals};
  }
  static constexpr FieldInfo backdriving_info(std::string_view text) {
    return {.name = "backdriving",
            .unit = "1",
            .text = text,
            .range = Range::at_most_one,
            .settable = false,
            .variables = of_speed,
            .reads = FormulaReads::signals};
  }

  // Calls visit(formula) for those that are given.
  template <class Losses, class Visit>
  static void each(Losses& of, Visit visit) {
    for (auto* formula : {&of.efficiency, &of.backdriving}) {
      if (formula->is_given()) visit(*formula);
    }
  }
  bool are_any() const {
    const bool is_lossless = !efficiency.is_given() || constant_value(efficiency) == 1.0;
    return !is_lossless || backdriving.is_given();
  }
  // The friction per force that the mesh exerts on the joint, if that joint drives, and if it is driven. speed: of the
  // joint; all: all signals.
  template <class T>
  std::array<T, 2> at(const T& speed, const T* all) const {
    const T of[] = {speed < T(0) ? T(-speed) : speed};
    const T driving = efficiency.is_given() ? T(T(1) / positive(efficiency, of, all) - T(1)) : T(0);
    return {driving, backdriving.is_given() ? T(T(1) - backdriving.value_among(of, all)) : driving};
  }

  // Within a step that passes a kink, the branch that is held may fall to 0 beyond it, where the state is on another.
  template <class T>
  static T positive(const Formula& efficiency, const T* of, const T* all) {
    T out = efficiency.value_among(of, all);
    if (out > T(0)) return out;
    std::array<T, Formula::max_signals> named;
    efficiency.take_signals(all, named.data());
    return efficiency.decide<T>(of, named.data(), nullptr);
  }

  std::optional<ElementFault> fault() const {
    const std::optional<double> driving = efficiency.is_given() ? constant_value(efficiency) : 1;
    if (driving && !(*driving > 0 && *driving <= 1))
      return {{"efficiency", text::number(*driving), "more than 0, and 1 or less"}};
    const std::optional<double> driven = backdriving.is_given() ? constant_value(backdriving) : 1;
    if (driven && !(*driven <= 1)) return {{"backdriving", text::number(*driven), "1 or less"}};
    return {};
  }
};

// An element with losses also has `lossy_joint`: which of its joints has this friction.
template <class C>
concept LosesPower = requires(const C& c) {
  c.losses();
  C::lossy_joint;
};

}  // namespace gelenk
