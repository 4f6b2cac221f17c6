// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>
#include <optional>
#include <string>

#include "field/field.h"
#include "util/text.h"

namespace gelenk {

// A hard limit of a ball joint, a set-valued law as that of a coordinate (element/joint_forces/joint_limit.h): the
// angle between an axis of the parent and one of the child may not exceed a bound, so that the axis of the child stays
// within a cone. At the bound a torque about the normal of both axes takes the value, never pulling, that keeps the
// axes within it; an impact ends with -restitution times the rate of the angle (Newton).
struct SwingLimit {
  double swing = 0;  // rad
  double restitution = 0;
  Direction parent_axis, child_axis;  // in the joint's frames F and M

  static std::span<const Field> fields() {
    static constexpr Field all[] = {
        field<&SwingLimit::swing>({.name = "swing",
                                   .unit = "rad",
                                   .text = "largest angle between parent_axis and child_axis: half the opening of a "
                                           "cone",
                                   .range = Range::positive,
                                   .required = true}),
        field<&SwingLimit::restitution>({.name = "restitution",
                                         .unit = "1",
                                         .text = "coefficient of restitution of impacts at this angle",
                                         .range = Range::fraction}),
        field<&SwingLimit::parent_axis>(
            {.name = "parent_axis", .text = "axis of the cone in the joint frame of the parent"}),
        field<&SwingLimit::child_axis>(
            {.name = "child_axis", .text = "axis in the joint frame of the child that stays within the cone"})};
    return all;
  }

  // An angle between two axes is at most pi, at which the direction of the torque is undefined.
  std::optional<ElementFault> fault() const {
    if (swing < std::numbers::pi) return {};
    return {{"limit.swing", text::with_unit(text::number(swing), "rad"), "less than pi rad: no swing is larger"}};
  }
};

}  // namespace gelenk
