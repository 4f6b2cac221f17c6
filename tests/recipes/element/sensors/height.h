// SPDX-License-Identifier: BSD-3-Clause
// Example of a sensor; tests/test_recipes.py adds it.
#pragma once

#include "element/sensors/sensor.h"

namespace gelenk {

// The height of a point and its rate of change.
struct Height {
  static constexpr std::string_view kind = "height";
  static constexpr std::string_view summary = "height of a point";
  static constexpr Port ports[] = {{.kind = Port::Kind::point, .name = "", .text = "The point"}};

  static std::span<const Field> fields() { return {}; }
  static constexpr SignalGroup outputs[] = {{"h", 0, "m", "height of a point of {body}", Stage::position},
                                            {"rise", 0, "m/s", "rate of change of the height", Stage::velocity}};

  template <class Seen>
  auto output(const Seen& seen, int group, int) const {
    const auto at = seen.frame(0);
    const auto X_W0 = seen.X_W0();
    using T = std::decay_t<decltype(at.v[0])>;
    return group == 0 ? X_W0.point(at.X_0P.p)[2] : T(X_W0.R.row(2).dot(at.v));
  }
};

}  // namespace gelenk
