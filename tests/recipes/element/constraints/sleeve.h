// SPDX-License-Identifier: BSD-3-Clause
// Example of a constraint between bodies; tests/test_recipes.py adds it.
#pragma once

#include "element/constraints/constraint.h"

namespace gelenk {

// The origin of M remains on the z axis of F: w = x and y of F, Phi = p_x and p_y.
struct Sleeve : NoCoordinates {
  static constexpr std::string_view kind = "sleeve";
  static constexpr std::string_view summary = "a point remains on a line";
  static constexpr Port ports[] = {{.kind = Port::Kind::frame, .name = "", .text = "The point"},
                                   {.kind = Port::Kind::frame, .name = "on", .text = "The line, its z axis"}};
  static constexpr int row_count = 2;

  static std::span<const Field> fields() { return {}; }
  static constexpr SignalGroup outputs[] = {{"f", 2, "N", "force on {body} along x and y of the line's frame"}};

  template <class Seen>
  auto output(const Seen& seen, int, int i) const {
    return seen.contact_force(i);
  }

  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    for (int i = 0; i < row_count; ++i) out[i] = rows::point<A>(X_FM, i);
    return row_count;
  }
  template <class A, class T>
  void rows_bias(const typename A::Pose&, const typename A::Motion&, T*) const {}
};

}  // namespace gelenk
