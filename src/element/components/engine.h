// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/components/component.h"

namespace gelenk {

// An engine or any drive whose torque follows a map with a delay of first order.
struct Engine {
  static constexpr std::string_view kind = "engine";
  static constexpr std::string_view summary =
      "a drive whose torque follows a map or an expression, optionally with a first-order lag";
  static constexpr Port ports[] = {driven_shaft};

  Formula torque;
  double time_constant = NAN;
  double gear_ratio = 1;
  double rotor_inertia = 0;

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Engine::torque>(signal_info(
            "torque", "N.m",
            "torque on the side of the engine, an expression, such as table(map, w, throttle); an input if not given")),
        field<&Engine::time_constant>({.name = "time_constant",
                                       .unit = "s",
                                       .text = "time constant with which the torque follows; at once if not given",
                                       .range = Range::positive,
                                       .optional = true}),
        field<&Engine::gear_ratio>(gear_ratio_info), field<&Engine::rotor_inertia>(rotor_inertia_info)};
    return all;
  }

  void describe(ComponentEquations& of) const {
    of.signal({"torque", "N.m", "torque on the side of the engine"}, torque);
    if (is_given(time_constant)) {
      of.state({"developed", "N.m", "developed torque on the side of the engine"},
               {"(torque - developed)/time_constant"});
      of.act({"gear_ratio*developed"});
    } else {
      of.act({"gear_ratio*torque"});
    }
    of.value({"power", "W", "mechanical power"}, {"{effort}*speed"});
  }
  double inertia() const { return reflected_inertia(gear_ratio, rotor_inertia); }
};

}  // namespace gelenk
