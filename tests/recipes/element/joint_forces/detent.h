// SPDX-License-Identifier: BSD-3-Clause
// Example of a law of friction on a joint coordinate; tests/test_recipes.py adds it.
#pragma once

#include "element/joint_forces/dry_friction.h"

namespace gelenk {

// A magnetic detent: hysteresis holds the coordinate, and resists its motion, near a position, by
//   holding (1 - x^2)^4,   x = (q - position) / width,   for |x| < 1.
struct Detent : DryFriction<Detent> {
  static constexpr std::string_view group = "detent";
  static constexpr std::string_view summary = "a magnetic detent, which holds the coordinate near a position";
  static constexpr std::string_view misfit = "has more than one degree of freedom";
  static bool fits(const JointKind& kind) { return kind.nv == 1; }

  static constexpr bool depends_on_position = true;

  double holding = 0;   // N m (N)
  double position = 0;  // rad (m)
  double width = 0;     // rad (m)

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Detent::holding>({.name = "holding",
                                 .unit = "{f}",
                                 .text = "largest effort of the detent on {coordinate}",
                                 .range = Range::not_negative,
                                 .required = true,
                                 .tunable = true}),
        field<&Detent::position>(
            {.name = "position", .unit = "{q}", .text = "position of the detent on {coordinate}", .tunable = true}),
        field<&Detent::width>({.name = "width",
                               .unit = "{q}",
                               .text = "distance from its position at which the detent on {coordinate} ceases to act",
                               .range = Range::positive,
                               .required = true,
                               .tunable = true})};
    return all;
  }

  double sticking_limit(double q, const double*) const { return near(q); }
  template <class T>
  T friction(int, const T& q, const T&, const T*) const {
    return near(q);
  }

 private:
  template <class T>
  T near(const T& q) const {
    const T x = (q - T(position)) / T(width);
    const T left = T(1) - x * x;
    if (left <= T(0)) return T(0);
    return T(holding) * left * left * left * left;
  }
};

}  // namespace gelenk
