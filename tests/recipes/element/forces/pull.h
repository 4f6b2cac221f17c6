// SPDX-License-Identifier: BSD-3-Clause
// Example of a force; tests/test_recipes.py adds it.
#pragma once

#include "element/forces/force.h"

namespace gelenk {

// A force of constant magnitude along the line between two points.
struct Pull {
  static constexpr std::string_view kind = "pull";
  static constexpr std::string_view summary = "a constant force between two points";
  static constexpr Port ports[] = {{.kind = Port::Kind::point, .name = "from", .text = "One point"},
                                   {.kind = Port::Kind::point, .name = "to", .text = "The other point"}};

  double size = 0;  // N

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&Pull::size>({.name = "size", .unit = "N", .text = "tension force", .tunable = true})};
    return all;
  }

  bool is_idle() const { return size == 0; }

  template <class At, class T>
  void act(At* at, const T*) const {
    const Vector3<T> d = at[1].p() - at[0].p();
    const Vector3<T> f = T(size) / d.norm() * d;
    at[0].push(f);
    at[1].push(-f);
  }
  template <class T, class At>
  T energy(const At* at) const {
    const Vector3<T> d = at[1].p() - at[0].p();
    return T(size) * d.norm();
  }
  template <class At>
  bool undefined(const At* at) const {
    return !is_idle() && at[1].p() == at[0].p();
  }
};

}  // namespace gelenk
