// SPDX-License-Identifier: BSD-3-Clause
// Example of a force; tests/test_recipes.py adds it.
#pragma once

#include "element/forces/force.h"

namespace gelenk {

// Two poles at the distance d attract each other with the force strength / d^2, of the potential -strength / d.
struct Magnet {
  static constexpr std::string_view kind = "magnet";
  static constexpr std::string_view summary = "two poles attract each other";
  static constexpr Port ports[] = {{.kind = Port::Kind::point, .name = "from", .text = "One pole"},
                                   {.kind = Port::Kind::point, .name = "to", .text = "The other pole"}};

  double strength = 0;  // N m2

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&Magnet::strength>({.name = "strength",
                                                              .unit = "N.m2",
                                                              .text = "attraction times the square of the distance",
                                                              .range = Range::not_negative,
                                                              .tunable = true})};
    return all;
  }

  bool is_idle() const { return strength == 0; }

  template <class At, class T>
  void act(At* at, const T*) const {
    const Vector3<T> d = at[1].p() - at[0].p();
    const T square = d.squaredNorm();
    if (square == T(0)) return;  // reported by undefined()
    const Vector3<T> f = T(strength) / (square * d.norm()) * d;
    at[0].push(f);
    at[1].push(-f);
  }
  template <class T, class At>
  T energy(const At* at) const {
    if (is_idle()) return T(0);  // also where the poles coincide
    return T(-strength) / Vector3<T>(at[1].p() - at[0].p()).norm();
  }
  template <class At>
  bool undefined(const At* at) const {
    return !is_idle() && (at[1].p() - at[0].p()).norm() <= 1e-9;
  }
};

}  // namespace gelenk
