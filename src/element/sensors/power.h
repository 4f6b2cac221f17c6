// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/sensors/sensor.h"

namespace gelenk {

// Power that a joint transmits to the bodies that it connects. The total is the power of its motors, springs and
// dampers, hence zero for a tree joint without these.
struct Power {
  static constexpr std::string_view kind = "power";
  static constexpr std::string_view summary = "power transmitted by a joint to its bodies";
  static constexpr Port ports[] = {{.kind = Port::Kind::joint, .name = "joint", .text = "Joint"}};
  static constexpr bool reads_reaction = true;

  static std::span<const Field> fields() { return {}; }
  static constexpr SignalGroup outputs[] = {
      {"child", 0, "W", "power transmitted by joint {joint} to its child body"},
      {"parent", 0, "W", "power transmitted by joint {joint} to its parent body"},
      {"total", 0, "W", "power supplied by the motors, springs and dampers of joint {joint}"}};

  template <class Seen>
  auto output(const Seen& seen, int group, int) const {
    const auto wrench = seen.reaction();
    const auto F = seen.frame(0);
    const auto M = seen.frame(1);
    using T = std::decay_t<decltype(F.v[0])>;
    const Vector3<T> v_parent = F.v + F.w.cross(M.X_0P.p - F.X_0P.p);
    if (group == 0) return T(wrench.f.dot(M.v) + wrench.n.dot(M.w));
    if (group == 1) return T(-wrench.f.dot(v_parent) - wrench.n.dot(F.w));
    return T(wrench.f.dot(M.v - v_parent) + wrench.n.dot(M.w - F.w));
  }
};

}  // namespace gelenk
