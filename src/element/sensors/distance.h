// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/sensors/sensor.h"

namespace gelenk {

// Distance between two points and its rate. If the points coincide, the rate is their relative speed, since the
// distance can only grow.
struct Distance {
  static constexpr std::string_view kind = "distance";
  static constexpr std::string_view summary = "distance between two points and its rate";
  static constexpr Port ports[] = {{.kind = Port::Kind::point, .name = "from", .text = "One point"},
                                   {.kind = Port::Kind::point, .name = "to", .text = "The other point"}};

  static std::span<const Field> fields() { return {}; }
  static constexpr SignalGroup outputs[] = {
      {"d", 0, "m", "distance between two points", Stage::position},
      {"v", 0, "m/s", "rate of the distance between two points", Stage::velocity}};

  template <class Seen>
  auto output(const Seen& seen, int group, int) const {
    const auto from = seen.frame(0);
    const auto to = seen.frame(1);
    using T = std::decay_t<decltype(from.v[0])>;
    const Vector3<T> p = to.X_0P.p - from.X_0P.p;
    const Vector3<T> v = to.v - from.v;
    T d = p.norm();
    if (group == 0) return d;
    return d > T(0) ? T(p.dot(v) / d) : T(v.norm());
  }
};

}  // namespace gelenk
