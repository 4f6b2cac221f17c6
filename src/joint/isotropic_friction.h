// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "field/field.h"
#include "util/text.h"

namespace gelenk {

// Dry friction of a joint along several of its velocities together, a set-valued law (Coulomb) that is the same in all
// directions: the moment of a rotation about any axis (turns), or the force of a translation in a plane or in space. At
// rest it takes the value, up to the size `static`, that keeps them at rest; in motion it is opposite to the relative
// velocity, with the size `coulomb`.
template <bool turns>
struct IsotropicFriction {
  static constexpr bool is_moment = turns;
  double coulomb = 0;                                              // N m (N), in motion
  double static_limit = std::numeric_limits<double>::quiet_NaN();  // N m (N), at rest; NaN: coulomb

  static std::span<const Field> fields() {
    static constexpr std::string_view unit = turns ? "N.m" : "N";
    static constexpr Field all[] = {
        field<&IsotropicFriction::coulomb>({.name = "coulomb",
                                            .unit = unit,
                                            .text = turns ? "moment of sliding friction, against the angular velocity"
                                                          : "force of sliding friction, against the velocity",
                                            .range = Range::not_negative,
                                            .required = true,
                                            .tunable = true}),
        field<&IsotropicFriction::static_limit>({.name = "static",
                                                 .unit = unit,
                                                 .text = turns ? "largest moment of static friction, about any axis"
                                                               : "largest force of static friction, in any direction",
                                                 .range = Range::not_negative,
                                                 .optional = true,
                                                 .tunable = true})};
    return all;
  }

  // path: of this friction in its joint.
  std::optional<ElementFault> fault(std::string_view path) const {
    const auto shown = [](double x) { return text::with_unit(text::number(x), turns ? "N m" : "N"); };
    if (coulomb == 0 && static_limit > 0)
      return {{std::string(path) + ".coulomb", shown(0), "more than 0 beside static, which is " + shown(static_limit)}};
    if (!(static_limit < coulomb)) return {};
    return {{std::string(path) + ".static", shown(static_limit), "at least coulomb, which is " + shown(coulomb)}};
  }
};

// One of a joint, along some of its velocities.
struct FrictionPart {
  std::string_view key;             // in the joint: "friction", "friction.translation"
  bool turns = false;               // a moment of rotations, otherwise a force of translations
  int dimension = 3;                // number of these velocities: 2 in the x-y plane of F
  double sliding = 0, at_rest = 0;  // N m, N: its largest sizes

  std::string_view effort() const { return turns ? "tau" : "f"; }
};

template <bool turns>
FrictionPart friction_part(std::string_view key, int dimension, const IsotropicFriction<turns>& of) {
  return {key, turns, dimension, of.coulomb, std::isnan(of.static_limit) ? of.coulomb : of.static_limit};
}

}  // namespace gelenk
