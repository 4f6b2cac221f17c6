// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/sensors/sensor.h"

namespace gelenk {

// Energy of the whole mechanism.
struct EnergySensor {
  static constexpr std::string_view kind = "energy";
  static constexpr std::string_view summary = "kinetic and potential energy of the mechanism";
  static constexpr std::span<const Port> ports = {};
  static constexpr bool of_whole = true;

  static std::span<const Field> fields() { return {}; }
  static constexpr SignalGroup outputs[] = {
      {"kinetic", 0, "J", "kinetic energy", Stage::velocity},
      {"potential", 0, "J", "potential energy of gravity, springs and stops", Stage::position},
      {"total", 0, "J", "sum of kinetic and potential energy", Stage::velocity}};

  template <class Seen>
  auto output(const Seen& seen, int group, int) const {
    const auto& energy = seen.energy();
    return group == 0 ? energy.kinetic : group == 1 ? energy.potential : energy.kinetic + energy.potential;
  }
};

}  // namespace gelenk
