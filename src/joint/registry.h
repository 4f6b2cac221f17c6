// SPDX-License-Identifier: BSD-3-Clause
// Every kind of joint, once. A new joint is one new header and one name in JointTypes.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <variant>

#include "joint/cylindrical.h"
#include "joint/free.h"
#include "joint/kind.h"
#include "joint/planar_joint.h"
#include "joint/prismatic.h"
#include "joint/reversed.h"
#include "joint/revolute.h"
#include "joint/spherical.h"
#include "joint/universal.h"
#include "joint/weld.h"

namespace gelenk {

// Most used first: the order of the tests when a joint's kind is looked at while computing.
using AnyJoint = std::variant<Revolute, Prismatic, Spherical, Universal, Cylindrical, PlanarJoint, Free, Weld>;

// A joint of the spanning tree, seen from the inner body outwards.
using TreeJoint = std::variant<Revolute, Prismatic, Spherical, Universal, Cylindrical, PlanarJoint, Free, Weld,
                               Reversed<Spherical>, Reversed<Universal>, Reversed<PlanarJoint>, Reversed<Free>>;

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

// The joint as the tree meets it; reversed: the outer body carries F. Joints that reverse by turning
// their frames (below) stay what they are.
TreeJoint tree_joint(const AnyJoint& joint, bool reversed);
bool reverses_by_turning(const AnyJoint& joint);

// R_UC: from the user's joint frame U to the frame C in which the joint's axis is z (universal: a = x).
Eigen::Matrix3d canonical_rotation(const AnyJoint& joint, std::span<const Eigen::Vector3d> axes);

// Signs that q and v take on when F and M are turned upside down (PlanarRole::normal only; else all 1).
std::span<const double> flip_signs(const AnyJoint& joint);

}  // namespace gelenk
