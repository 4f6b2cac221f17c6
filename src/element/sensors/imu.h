// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/sensors/sensor.h"

namespace gelenk {

// Inertial measurement unit: what accelerometers and gyroscopes fixed in a frame measure.
struct Imu {
  static constexpr std::string_view kind = "imu";
  static constexpr std::string_view summary = "accelerations and angular velocity of a frame, in its own axes";
  static constexpr Port ports[] = {{.kind = Port::Kind::frame, .name = "", .text = "The frame"}};
  static constexpr bool reads_acceleration = true, reads_gravity = true;

  static std::span<const Field> fields() { return {}; }
  static constexpr SignalGroup outputs[] = {
      {"a", 3, "m/s2", "acceleration of the frame on {body}, resolved in that frame"},
      {"specific_force", 3, "m/s2", "the same less gravity, as accelerometers measure it; upward at rest"},
      {"w", 3, "rad/s", "angular velocity of the frame on {body}, resolved in that frame", Stage::velocity},
      {"alpha", 3, "rad/s2", "angular acceleration of the frame on {body}, resolved in that frame"}};

  template <class Seen>
  auto output(const Seen& seen, int group, int i) const {
    const auto at = seen.frame(0);
    using T = std::decay_t<decltype(at.v[0])>;
    if (group == 2) return T(at.X_0P.R.col(i).dot(at.w));
    const auto rates = seen.acceleration(0);
    if (group == 3) return T(at.X_0P.R.col(i).dot(rates.alpha));
    const Vector3<T> a = group == 0 ? rates.a : Vector3<T>(rates.a - seen.gravity());
    return T(at.X_0P.R.col(i).dot(a));
  }
};

}  // namespace gelenk
