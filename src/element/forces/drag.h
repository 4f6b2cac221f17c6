// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/forces/force.h"
#include "element/forces/resistance.h"

namespace gelenk {

// A force on a body at a point with velocity v in the world: -(damping + coefficient |v|) v.
struct Drag {
  static constexpr std::string_view kind = "drag";
  static constexpr std::string_view summary = "a force opposite to the velocity of a point";
  static constexpr Port ports[] = {
      {.kind = Port::Kind::point, .name = "", .text = "Where it acts", .on_ground = false}};

  double damping = 0;      // N s/m
  double coefficient = 0;  // N s2/m2: half the density times the drag area

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&Drag::damping>({.name = "damping",
                                                           .unit = "N.s/m",
                                                           .text = "force per velocity",
                                                           .range = Range::not_negative,
                                                           .tunable = true}),
                                    field<&Drag::coefficient>({.name = "coefficient",
                                                               .unit = "N.s2/m2",
                                                               .text = "force per velocity squared",
                                                               .range = Range::not_negative,
                                                               .tunable = true})};
    return all;
  }

  bool is_idle() const { return damping == 0 && coefficient == 0; }

  template <class At, class T>
  void act(At* at, const T*) const {
    at[0].push(resistance<T>(damping, coefficient, at[0].v()));
  }
};

}  // namespace gelenk
