// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/sensors/sensor.h"

namespace gelenk {

// Pose and velocity of a frame.
struct FrameSensor {
  static constexpr std::string_view kind = "frame";
  static constexpr std::string_view summary = "pose and velocity of a frame";
  static constexpr Port ports[] = {{.kind = Port::Kind::frame, .name = "", .text = "The frame"}};

  static std::span<const Field> fields() { return {}; }
  static constexpr SignalGroup outputs[] = {
      {"r", 3, "m", "position of the frame on {body} in the world", Stage::position},
      {"Q", 4, "1", "unit quaternion of the frame on {body} in the world", Stage::position},
      {"v", 3, "m/s", "velocity of the frame on {body}, resolved in the world", Stage::velocity},
      {"w", 3, "rad/s", "angular velocity of the frame on {body}, resolved in that frame", Stage::velocity}};

  template <class Seen>
  auto output(const Seen& seen, int group, int i) const {
    const auto X_W0 = seen.X_W0();
    using T = std::decay_t<decltype(X_W0.p[0])>;
    switch (group) {
      case 0:
        return X_W0.point(seen.pose(0).p)[i];
      case 1:
        return quaternion_component<T>(X_W0.R * seen.pose(0).R, i);
      case 2:
        return T(X_W0.R.row(i).dot(seen.frame(0).v));
      default: {
        const auto at = seen.frame(0);
        return T(at.X_0P.R.col(i).dot(at.w));
      }
    }
  }
};

}  // namespace gelenk
