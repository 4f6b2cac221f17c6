// SPDX-License-Identifier: BSD-3-Clause
// What may close a loop.
#pragma once

#include <variant>

#include "element/registry.h"
#include "joint/registry.h"
#include "joint/rod.h"

namespace gelenk {
namespace detail {

template <class C>
using BodyConstraintOrNone = std::conditional_t<BodyConstraint<C>, std::tuple<C>, std::tuple<>>;
template <class Joints, class Constraints>
struct Closing;
template <class... J, class... C>
struct Closing<std::variant<J...>, std::variant<C...>> {
  using type = typename AsVariant<decltype(std::tuple_cat(std::tuple<J..., Rod>(),
                                                          std::declval<BodyConstraintOrNone<C>>()...))>::type;
};

}  // namespace detail

// The joints, in the order of AnyJoint; rods that stand for a body without mass; constraints between bodies.
using CutJoint = detail::Closing<AnyJoint, AnyConstraint>::type;

inline CutJoint cut_joint(const AnyJoint& joint) {
  return std::visit([](const auto& j) { return CutJoint(j); }, joint);
}

// Whether the joint's row i holds positions; else it holds their rates alone (non-holonomic).
inline bool holds_position(const CutJoint& joint, int i) {
  return std::visit(
      [i](const auto& j) {
        if constexpr (requires { j.holds_position(i); }) return j.holds_position(i);
        return true;
      },
      joint);
}

// Whether its rows are not defined there.
inline bool is_undefined(const CutJoint& joint, const Pose3& X_FM) {
  return std::visit(
      [&](const auto& j) {
        if constexpr (requires { j.undefined(X_FM); }) return j.undefined(X_FM);
        return false;
      },
      joint);
}

}  // namespace gelenk
