// SPDX-License-Identifier: BSD-3-Clause
// What motors and drives at a joint share: the joint, a gear ratio and the inertia of a rotor.
#pragma once

#include "element/element.h"

namespace gelenk {

inline constexpr Port driven_joint = {.kind = Port::Kind::joint,
                                      .name = "joint",
                                      .text = "Joint with one degree of freedom",
                                      .fits = [](const JointKind& kind) { return kind.nq == 1 && kind.nv == 1; }};

// A joint of which one coordinate is driven.
inline constexpr Port driven_coordinate = {.kind = Port::Kind::joint,
                                           .name = "joint",
                                           .text = "Joint with coordinates that are angles or lengths",
                                           .has_coordinate = true,
                                           .fits = [](const JointKind& kind) { return kind.springs(); }};

inline constexpr FieldInfo gear_ratio_info = {.name = "gear_ratio",
                                              .unit = "1",
                                              .text = "travel of the motor per travel of joint {joint}",
                                              .range = Range::not_zero};
inline constexpr FieldInfo rotor_inertia_info = {
    .name = "rotor_inertia", .unit = "{J}", .text = "rotor inertia on the motor side", .range = Range::not_negative};

// The inertia that a rotor adds to the coordinate of the joint.
inline double reflected_inertia(double gear_ratio, double rotor_inertia) {
  return gear_ratio * gear_ratio * rotor_inertia;
}

}  // namespace gelenk
