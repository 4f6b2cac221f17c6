// SPDX-License-Identifier: BSD-3-Clause
// Every kind of joint, once. A new one is one new header and one name in AnyJoint; TreeJoint and CutJoint follow.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "joint/cylindrical.h"
#include "joint/free.h"
#include "joint/kind.h"
#include "joint/planar_joint.h"
#include "joint/prismatic.h"
#include "joint/reversed.h"
#include "joint/revolute.h"
#include "joint/screw.h"
#include "joint/spherical.h"
#include "joint/universal.h"
#include "joint/weld.h"

namespace gelenk {

// Most used first: the order of the tests when a joint's kind is looked at while computing.
using AnyJoint = std::variant<Revolute, Prismatic, Spherical, Universal, Cylindrical, PlanarJoint, Free, Screw, Weld>;

namespace detail {

// Those whose roles turning does not serialize, reversed.
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

// A joint of the spanning tree, seen from the inner body outwards.
using TreeJoint = detail::InTree<AnyJoint>::type;

// Joints that stay in a plane have code in planar algebra.
template <class A, class J>
constexpr bool lives_in = !A::planar || J::planar != PlanarRole::never;

// All kinds, in the order of AnyJoint.
std::span<const JointKind> joint_kinds();

// The kind of that name, or nullptr.
const JointKind* find_joint_kind(std::string_view name);

// A joint of the kind with that name. axes: unit vectors in the user's joint frame, as many as the kind has.
// Throws std::out_of_range for an unknown name.
AnyJoint make_joint(std::string_view kind, std::span<const Eigen::Vector3d> axes);

const JointKind& kind_of(const AnyJoint& joint);

// The user's axes where none are given.
std::vector<Eigen::Vector3d> default_axes(const JointKind& kind);

// The joint itself, for its fields.
inline void* data_of(AnyJoint& joint) {
  return std::visit([](auto& j) -> void* { return &j; }, joint);
}
inline const void* data_of(const AnyJoint& joint) {
  return std::visit([](const auto& j) -> const void* { return &j; }, joint);
}

// The joint as the tree meets it; reversed: the outer body carries F. Joints that reverse by turning
// their frames (below) stay what they are.
TreeJoint tree_joint(const AnyJoint& joint, bool reversed);
bool reverses_by_turning(const AnyJoint& joint);

// R_UC: from the user's joint frame U to the frame C in which the joint's axis is z (universal: a = x).
Eigen::Matrix3d canonical_rotation(const AnyJoint& joint, std::span<const Eigen::Vector3d> axes);

// Signs that q and v take on when F and M are turned upside down (PlanarRole::normal only; else all 1).
std::span<const double> flip_signs(const AnyJoint& joint);

}  // namespace gelenk
