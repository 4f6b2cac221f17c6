// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "element/sensors/sensor.h"

namespace gelenk {

// Angles of three rotations, each about an axis of the frame turned by those before, that take `to` to the frame:
// R = R_i(angle 1) R_j(angle 2) R_k(angle 3).
struct EulerAngles {
  static constexpr std::string_view kind = "euler_angles";
  static constexpr std::string_view summary = "orientation of a frame by three angles, in any of the twelve sequences";
  static constexpr Port ports[] = {
      {.kind = Port::Kind::frame, .name = "", .text = "The frame"},
      {.kind = Port::Kind::frame, .name = "to", .text = "Frame to which the angles refer", .optional = true}};
  static constexpr std::string_view sequences[] = {"xyz", "yzx", "zxy", "xzy", "zyx", "yxz",
                                                   "xyx", "yzy", "zxz", "xzx", "zyz", "yxy"};

  Choice sequence = {0};

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&EulerAngles::sequence>(
        {.name = "sequence", .text = "axes of the three rotations, in their order", .words = sequences})};
    return all;
  }
  static constexpr SignalGroup outputs[] = {
      {"angle", 3, "rad", "angles of the frame on {body}; the first and the last in [-pi, pi]", Stage::position}};

  template <class Seen>
  auto output(const Seen& seen, int, int component) const {
    using std::atan2;
    using std::sqrt;
    const auto at = seen.pose(0);
    using T = std::decay_t<decltype(at.p[0])>;
    const Matrix3<T> R = seen.pose(1).R.transpose() * at.R;
    const std::string_view axes = sequences[static_cast<std::size_t>(sequence.index)];
    const int i = axes[0] - 'x';
    const int j = axes[1] - 'x';
    const bool is_proper = axes[2] == axes[0];
    const int k = 3 - i - j;
    const T e((j - i + 3) % 3 == 1 ? 1 : -1);
    // Where the axes of the first and the third rotation coincide, only the sum or the difference of both is known: the
    // third is 0.
    constexpr double coincident = 1e-12;
    const T across =
        is_proper ? sqrt(R(i, j) * R(i, j) + R(i, k) * R(i, k)) : sqrt(R(i, i) * R(i, i) + R(i, j) * R(i, j));
    const bool is_singular = across < T(coincident);
    if (component == 1) return is_proper ? T(atan2(across, R(i, i))) : T(atan2(e * R(i, k), across));
    if (component == 2) {
      if (is_singular) return T(0);
      return is_proper ? T(atan2(R(i, j), e * R(i, k))) : T(atan2(-e * R(i, j), R(i, i)));
    }
    if (is_singular) return T(atan2(e * R(k, j), R(j, j)));
    return is_proper ? T(atan2(R(j, i), -e * R(k, i))) : T(atan2(-e * R(j, k), R(k, k)));
  }
};

}  // namespace gelenk
