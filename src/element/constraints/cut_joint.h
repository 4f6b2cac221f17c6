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
template <class Constraints>
struct BetweenBodies;
template <class... C>
struct BetweenBodies<std::variant<C...>> {
  using type = typename AsVariant<decltype(std::tuple_cat(std::declval<BodyConstraintOrNone<C>>()...))>::type;
};
template <class Joints, class... More>
struct Closing;
template <class... J, class... More>
struct Closing<std::variant<J...>, More...> {
  using type = std::variant<J..., More...>;
};

}  // namespace detail

// Any constraint between bodies. The kernels know this one type for all of them: each type that closes loops is
// compiled into every kernel.
struct AnyBodyConstraint : NoCoordinates {
  detail::BetweenBodies<AnyConstraint::variant>::type is;

  template <class A>
  int rows(const typename A::Pose& X_FM, Row<A>* out) const {
    return std::visit([&](const auto& c) { return c.template rows<A>(X_FM, out); }, is);
  }
  template <class A, class T>
  void rows_bias(const typename A::Pose& X_FM, const typename A::Motion& V, T* bias) const {
    std::visit([&](const auto& c) { c.template rows_bias<A>(X_FM, V, bias); }, is);
  }
};

// The joints, in the order of AnyJoint; rods in place of massless bodies; constraints between bodies. Copied where
// models are made, in code that is not repeated in each of them.
struct CutJoint : detail::Closing<AnyJoint::variant, Rod, AnyBodyConstraint>::type {
  using variant::variant;
  CutJoint();
  CutJoint(const CutJoint& other);
  CutJoint(CutJoint&& other) noexcept;
  CutJoint& operator=(const CutJoint& other);
  CutJoint& operator=(CutJoint&& other) noexcept;
  ~CutJoint();
};

}  // namespace gelenk
