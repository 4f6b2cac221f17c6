// SPDX-License-Identifier: BSD-3-Clause
// Losses of gears and racks: of the power that enters the mesh, the part `efficiency` leaves it if the joint drives of
// which they are friction, and `backdriving` if it is driven. By default, friction is equal in both directions,
// backdriving = 2 - 1 / efficiency; at 0 or less the mesh is self-locking. Both may be expressions of the sizes of the
// speed of that joint and of the torque that the mesh exerts on it, and of signals.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "element/element.h"
#include "util/text.h"

namespace gelenk {

struct MeshLosses {
  static constexpr FormulaVariable of_motion[] = {{"w", "rad/s", true}, {"tau", "N.m", true}};

  Formula efficiency, backdriving;

  static constexpr FieldInfo efficiency_info(std::string_view text) {
    return {.name = "efficiency",
            .unit = "1",
            .text = text,
            .range = Range::fraction,
            .settable = false,
            .variables = of_motion,
            .reads = FormulaReads::signals};
  }
  static constexpr FieldInfo backdriving_info(std::string_view text) {
    return {.name = "backdriving",
            .unit = "1",
            .text = text,
            .range = Range::at_most_one,
            .settable = false,
            .variables = of_motion,
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
  // Whether an expression names the torque. Its branches are not held: where they change is not known before the
  // torque.
  static bool names_load(const Formula& formula) { return formula.is_given() && names_variable(formula, 1); }
  bool depend_on_load() const { return names_load(efficiency) || names_load(backdriving); }
  // The friction per force that the mesh exerts on the joint, if that joint drives, and if it is driven. speed: of the
  // joint; load: the size of that force; all: all signals.
  template <class T, class Signal>
  std::array<T, 2> at(const T& speed, const T& load, const Signal* all) const {
    const T of[] = {speed < T(0) ? T(-speed) : speed, load};
    const T driving = efficiency.is_given() ? T(T(1) / positive(efficiency, of, all) - T(1)) : T(0);
    return {driving,
            backdriving.is_given() ? T(T(1) - backdriving.value(of, named<T>(backdriving, all).data())) : driving};
  }

 private:
  template <class T, class Signal>
  static std::array<T, Formula::max_signals> named(const Formula& formula, const Signal* all) {
    std::array<T, Formula::max_signals> out;
    std::ranges::transform(formula.signals(), out.begin(), [&](int signal) { return T(all[signal]); });
    return out;
  }
  // Within a step that passes a kink, the branch that is held may fall to 0 beyond it, where the state is on another.
  template <class T, class Signal>
  static T positive(const Formula& efficiency, const T* of, const Signal* all) {
    const auto signals = named<T>(efficiency, all);
    const T out = efficiency.value(of, signals.data());
    return out > T(0) ? out : efficiency.decide<T>(of, signals.data(), nullptr);
  }

 public:
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
