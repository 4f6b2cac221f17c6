// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "element/forces/force.h"
#include "element/forces/resistance.h"

namespace gelenk {

// A torque on a body with angular velocity w in the world: -(damping + coefficient |w|) w.
struct Moment {
  static constexpr std::string_view kind = "moment";
  static constexpr std::string_view summary = "a torque opposite to the angular velocity of a body";
  static constexpr Port ports[] = {
      {.kind = Port::Kind::body, .name = "", .text = "Body on which it acts", .on_ground = false}};

  double damping = 0;      // N m s/rad
  double coefficient = 0;  // N m s2/rad2

  static std::span<const Field> fields() {
    static constexpr Field all[] = {field<&Moment::damping>({.name = "damping",
                                                             .unit = "N.m.s/rad",
                                                             .text = "torque per angular velocity",
                                                             .range = Range::not_negative,
                                                             .tunable = true}),
                                    field<&Moment::coefficient>({.name = "coefficient",
                                                                 .unit = "N.m.s2/rad2",
                                                                 .text = "torque per angular velocity squared",
                                                                 .range = Range::not_negative,
                                                                 .tunable = true})};
    return all;
  }

  bool is_idle() const { return damping == 0 && coefficient == 0; }

  template <class At, class T>
  void act(At* at, const T*) const {
    at[0].push(Vector3<T>(Vector3<T>::Zero()), resistance<T>(damping, coefficient, at[0].w()));
  }
};

}  // namespace gelenk
