// SPDX-License-Identifier: BSD-3-Clause
// The list of all joint types. A new type requires a header and its name in AnyJoint; TreeJoint and CutJoint follow.
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

// In order of frequency, which is the order in which kernels test the type of a joint.
using AnyJoint = std::variant<Revolute, Prismatic, Spherical, Universal, Cylindrical, PlanarJoint, Free, Screw, Weld>;

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
using TreeJoint = detail::InTree<AnyJoint>::type;

// Whether J has code in the algebra A: in planar algebra only if it has planar motions.
template <class A, class J>
constexpr bool supports_algebra = !A::planar || J::planar != PlanarRole::never;

// All joint types, in the order of AnyJoint.
std::span<const JointKind> joint_kinds();

// Returns the joint type of this name, or nullptr.
const JointKind* find_joint_kind(std::string_view name);

// Makes a joint of the named type. axes: unit vectors in the user's joint frame, as many as the type has.
// Throws std::out_of_range for an unknown name.
AnyJoint make_joint(std::string_view kind, std::span<const Eigen::Vector3d> axes);

// Returns the type of a joint.
const JointKind& kind_of(const AnyJoint& joint);

// Returns the axes, in the user's joint frame, of a joint for which none are given.
std::vector<Eigen::Vector3d> default_axes(const JointKind& kind);

// Address of the joint in the variant, to which its fields refer.
inline void* data_of(AnyJoint& joint) {
  return std::visit([](auto& j) -> void* { return &j; }, joint);
}
inline const void* data_of(const AnyJoint& joint) {
  return std::visit([](const auto& j) -> const void* { return &j; }, joint);
}

// Returns the joint as a joint of the spanning tree; reversed: F is on the outer body. Joints that are reversed by
// half a turn of their frames (reverses_by_turning()) are returned unchanged.
TreeJoint tree_joint(const AnyJoint& joint, bool reversed);
// Whether half a turn of both frames about x exchanges the roles of F and M.
bool reverses_by_turning(const AnyJoint& joint);

// Returns R_UC, from the user's joint frame U to the frame C in which the axis of the joint is z (universal: a = x).
Eigen::Matrix3d canonical_rotation(const AnyJoint& joint, std::span<const Eigen::Vector3d> axes);

// Returns the signs by which q and v change if F and M are rotated by half a turn about x, which reverses the normal;
// all 1 unless the joint has PlanarRole::normal.
std::span<const double> flip_signs(const AnyJoint& joint);

}  // namespace gelenk
