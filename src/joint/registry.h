// SPDX-License-Identifier: BSD-3-Clause
// The list of all joint types. A new type requires a header and its name in AnyJoint; TreeJoint and CutJoint follow.
#pragma once

#include <tuple>
#include <utility>
#include <variant>

#include "joint/cylindrical.h"
#include "joint/free.h"
#include "joint/kinds.h"
#include "joint/planar_joint.h"
#include "joint/prismatic.h"
#include "joint/reversed.h"
#include "joint/revolute.h"
#include "joint/screw.h"
#include "joint/spherical.h"
#include "joint/universal.h"
#include "joint/weld.h"

namespace gelenk {

// In order of frequency, which is the order in which kernels test the type of a joint.
struct AnyJoint : std::variant<Revolute, Prismatic, Spherical, Universal, Cylindrical, PlanarJoint, Free, Screw, Weld> {
  using variant::variant;
};

namespace detail {

// Reversed<J> for joints that half a turn does not reverse; otherwise empty.
template <class J>
using ReversedOrNone = std::conditional_t<J::reverses_by_half_turn, std::tuple<>, std::tuple<Reversed<J>>>;
template <class Tuple>
struct AsVariant;
template <class... J>
struct AsVariant<std::tuple<J...>> {
  using type = std::variant<J...>;
};
template <class Any>
struct InTree;
template <class... J>
struct InTree<std::variant<J...>> {
  using type =
      typename AsVariant<decltype(std::tuple_cat(std::tuple<J...>(), std::declval<ReversedOrNone<J>>()...))>::type;
};

}  // namespace detail

// A joint of the spanning tree, from the inner body to the outer one.
struct TreeJoint : detail::InTree<AnyJoint::variant>::type {
  using variant::variant;
};

// Whether J has code in the algebra A: in planar algebra only if it has planar motions.
template <class A, class J>
constexpr bool supports_algebra = !A::planar || J::planar != PlanarRole::never;

}  // namespace gelenk
