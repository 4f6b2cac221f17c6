// SPDX-License-Identifier: BSD-3-Clause
// Example of an effort on a joint coordinate, with a mapping of its own in the scene; tests/test_recipes.py adds it.
#pragma once

#include "element/joint_forces/coordinate_force.h"

namespace gelenk {

// tau = effort.
struct Preload {
  static constexpr std::string_view group = "preload";
  static constexpr std::string_view summary = "a constant effort";
  static constexpr std::string_view misfit = "has more than one degree of freedom";
  static bool fits(const JointKind& kind) { return kind.nv == 1; }

  double size = 0;  // N m (N)

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&Preload::size>(
        {.name = "size", .unit = "{f}", .text = "effort on {coordinate}", .required = true, .tunable = true})};
    return all;
  }

  template <class T>
  T effort(const T&, const T&, const T*) const {
    return T(size);
  }
  template <class T>
  T energy(const T& q) const {
    return -T(size) * q;
  }
};

}  // namespace gelenk
