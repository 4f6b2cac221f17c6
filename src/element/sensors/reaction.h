// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/sensors/sensor.h"

namespace gelenk {

// Force and torque of a joint on its child body.
struct Reaction {
  static constexpr std::string_view kind = "reaction";
  static constexpr std::string_view summary = "force and torque of a joint on its child body";
  static constexpr Port ports[] = {{.kind = Port::Kind::joint, .name = "joint", .text = "Joint"}};
  static constexpr bool reads_reaction = true;

  static std::span<const Field> fields() { return {}; }
  static constexpr SignalGroup outputs[] = {
      {"f", 3, "N", "force of joint {joint} on its child body, at the joint's frame M, resolved in its frame F"},
      {"t", 3, "N.m", "torque of joint {joint} on its child body, at the joint's frame M, resolved in its frame F"}};

  template <class Seen>
  auto output(const Seen& seen, int group, int i) const {
    const auto wrench = seen.reaction();
    return seen.pose(0).R.col(i).dot(group == 0 ? wrench.f : wrench.n);
  }
};

}  // namespace gelenk
