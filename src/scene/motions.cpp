// SPDX-License-Identifier: BSD-3-Clause
#include "scene/motions.h"

#include <algorithm>
#include <optional>
#include <string>

namespace gelenk {

MotionOfSignals motion_of_signals(const Scene& scene, const Motion& of, const FormulaNames& names,
                                  const std::function<void(const Formula&, int order)>& seen) {
  const auto rate_of = [&](std::string_view signal) -> std::optional<std::string> {
    const auto state = std::ranges::find(scene.states, signal, &ElementState::name);
    if (state == scene.states.end()) return std::nullopt;
    return std::string(state->rate.text());
  };
  MotionOfSignals out;
  std::size_t given = of.holds_position() ? 0 : 1;
  const Formula& law = of.law_of_signals();
  const double second = scene.units.size_of("s");
  // The time is the signal here, so that the formulas have no variables.
  out[given] = Formula(std::string(law.text()), {}, names, FormulaReads::signals);
  out[given].set_sizes(law.size(), {});
  for (; given < 2; ++given) {
    if (seen) seen(out[given], static_cast<int>(given));
    out[given + 1] = time_derivative(out[given], names, rate_of);
    out[given + 1].set_sizes(out[given].size() / second, {});
  }
  return out;
}

const Motion* find_motion_of_signals(const Constraint& constraint) {
  const Motion* const motion = find_motion(*constraint.is);
  return motion != nullptr && motion->follows_signals() ? motion : nullptr;
}

bool has_motions_of_signals(const Scene& scene) {
  return std::ranges::any_of(scene.constraints,
                             [](const Constraint& of) { return find_motion_of_signals(of) != nullptr; });
}

}  // namespace gelenk
