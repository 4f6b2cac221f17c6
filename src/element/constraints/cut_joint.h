// SPDX-License-Identifier: BSD-3-Clause
// CutJoint: everything that can close a loop.
#pragma once

#include <variant>

#include "element/constraints/registry.h"
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
struct CutJoint : detail::Closing<AnyJoint::variant, AnyConstraint::variant>::type {
  using variant::variant;
};

}  // namespace gelenk
