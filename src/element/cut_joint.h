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

// Of a constraint between bodies.
inline int row_count(const CutJoint& joint) {
  return std::visit(
      [](const auto& j) -> int {
        if constexpr (BodyConstraint<std::decay_t<decltype(j)>>) return j.row_count;
        return 0;
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
// Whether there are such places, what is wrong with a start there, and what ends a run near one; empty elsewhere.
inline bool can_be_undefined(const CutJoint& joint) {
  return std::visit([](const auto& j) { return requires(const Pose3& X) { j.undefined(X); }; }, joint);
}
inline ElementFault undefined_start(const CutJoint& joint) {
  return std::visit(
      [](const auto& j) -> ElementFault {
        if constexpr (requires { j.undefined_start(); }) return j.undefined_start();
        return {};
      },
      joint);
}
inline std::string_view near_undefined(const CutJoint& joint, const Pose3& X_FM) {
  return std::visit(
      [&](const auto& j) -> std::string_view {
        if constexpr (requires { j.near_undefined(X_FM); }) return j.near_undefined(X_FM);
        return {};
      },
      joint);
}

}  // namespace gelenk
