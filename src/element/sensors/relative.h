// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/sensors/sensor.h"

namespace gelenk {

// Pose, velocity and acceleration of a frame relative to another one, as an observer that moves with that one sees
// them.
struct Relative {
  static constexpr std::string_view kind = "relative";
  static constexpr std::string_view summary = "pose, velocity and acceleration of a frame relative to another one";
  static constexpr Port ports[] = {{.kind = Port::Kind::frame, .name = "", .text = "The frame"},
                                   {.kind = Port::Kind::frame, .name = "to", .text = "Frame of the observer"}};
  static constexpr bool reads_acceleration = true;

  static std::span<const Field> fields() { return {}; }
  static constexpr SignalGroup outputs[] = {
      {"r", 3, "m", "position of the frame on {body} in the frame `to`", Stage::position},
      {"Q", 4, "1", "unit quaternion of the frame on {body} in the frame `to`", Stage::position},
      {"v", 3, "m/s", "rate of r", Stage::velocity},
      {"w", 3, "rad/s", "angular velocity relative to the frame `to`, resolved in it", Stage::velocity},
      {"a", 3, "m/s2", "rate of v"},
      {"alpha", 3, "rad/s2", "rate of w"}};

  template <class Seen>
  auto output(const Seen& seen, int group, int i) const {
    const auto to = seen.frame(1);
    using T = std::decay_t<decltype(to.v[0])>;
    const auto at = seen.frame(0);
    const auto resolved = [&](const Vector3<T>& x) { return T(to.X_0P.R.col(i).dot(x)); };
    if (group == 1) return quaternion_component<T>(to.X_0P.R.transpose() * at.X_0P.R, i);
    const Vector3<T> d = at.X_0P.p - to.X_0P.p;
    const Vector3<T> v = at.v - to.v - to.w.cross(d);
    switch (group) {
      case 0:
        return resolved(d);
      case 2:
        return resolved(v);
      case 3:
        return resolved(at.w - to.w);
      default: {
        const auto a1 = seen.acceleration(0);
        const auto a0 = seen.acceleration(1);
        if (group == 5) return resolved(a1.alpha - a0.alpha - to.w.cross(at.w));
        // Less the accelerations of Euler, Coriolis and toward the axis.
        return resolved(a1.a - a0.a - a0.alpha.cross(d) - to.w.cross(to.w.cross(d)) - T(2) * to.w.cross(v));
      }
    }
  }
};

}  // namespace gelenk
