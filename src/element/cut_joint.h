// SPDX-License-Identifier: BSD-3-Clause
// CutJoint: everything that can close a loop.
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

// The joints, in the order of AnyJoint; rods in place of massless bodies; constraints between bodies.
using CutJoint = detail::Closing<AnyJoint, AnyConstraint>::type;

// Converts a joint to a CutJoint.
inline CutJoint cut_joint(const AnyJoint& joint) {
  return std::visit([](const auto& j) { return CutJoint(j); }, joint);
}

// Whether constraint equation i constrains a position; otherwise it constrains a velocity only (nonholonomic).
inline bool holds_position(const CutJoint& joint, int i) {
  return std::visit(
      [i](const auto& j) {
        if constexpr (requires { j.holds_position(i); }) return j.holds_position(i);
        return true;
      },
      joint);
}

// Number of constraint equations of a constraint between bodies; 0 for joints and rods.
inline int row_count(const CutJoint& joint) {
  return std::visit(
      [](const auto& j) -> int {
        if constexpr (BodyConstraint<std::decay_t<decltype(j)>>) return j.row_count;
        return 0;
      },
      joint);
}

// Whether the constraint equations are undefined at this pose.
inline bool is_undefined(const CutJoint& joint, const Pose3& X_FM) {
  return std::visit(
      [&](const auto& j) {
        if constexpr (requires { j.undefined(X_FM); }) return j.undefined(X_FM);
        return false;
      },
      joint);
}
// Whether there are poses at which the constraint equations are undefined.
inline bool can_be_undefined(const CutJoint& joint) {
  return std::visit([](const auto& j) { return requires(const Pose3& X) { j.undefined(X); }; }, joint);
}
// The fault of a start at such a pose.
inline ElementFault undefined_start(const CutJoint& joint) {
  return std::visit(
      [](const auto& j) -> ElementFault {
        if constexpr (requires { j.undefined_start(); }) return j.undefined_start();
        return {};
      },
      joint);
}
// The reason why a run ends near such a pose; empty elsewhere.
inline std::string_view near_undefined(const CutJoint& joint, const Pose3& X_FM) {
  return std::visit(
      [&](const auto& j) -> std::string_view {
        if constexpr (requires { j.near_undefined(X_FM); }) return j.near_undefined(X_FM);
        return {};
      },
      joint);
}

}  // namespace gelenk
