// SPDX-License-Identifier: BSD-3-Clause
// Joints of all types, for code that does not depend on particular types: these are in registry.h.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "joint/kind.h"
#include "util/stored.h"

namespace gelenk {

struct AnyJoint;   // a joint of a scene
struct TreeJoint;  // a joint of the spanning tree
extern template class Stored<AnyJoint>;
extern template class Stored<TreeJoint>;

// All joint types, in the order of AnyJoint.
std::span<const JointKind> joint_kinds();

// Returns the joint type of this name, or nullptr.
const JointKind* find_joint_kind(std::string_view name);

// Makes a joint of the named type. axes: unit vectors in the user's joint frame, as many as the type has.
// Throws std::out_of_range for an unknown name.
Stored<AnyJoint> make_joint(std::string_view kind, std::span<const Eigen::Vector3d> axes);

// Returns the type of a joint.
const JointKind& kind_of(const AnyJoint& joint);

// Returns the axes, in the user's joint frame, of a joint for which none are given.
std::vector<Eigen::Vector3d> default_axes(const JointKind& kind);

// Address of the joint in the variant, to which its fields refer.
void* data_of(AnyJoint& joint);
const void* data_of(const AnyJoint& joint);

// The limit of its swing; null: it has none.
struct SwingLimit;
const SwingLimit* swing_limit_of(const AnyJoint& joint);
// Its dry friction along several velocities together.
struct FrictionPart;
std::vector<FrictionPart> friction_parts_of(const AnyJoint& joint);
// Returns the error in its parameters that the ranges of the fields do not cover, if there is one.
std::optional<ElementFault> fault_of(const AnyJoint& joint);

// Pose of the joint's frame M in F, and the rates of its coordinates at the velocities v; in the joint's canonical
// frames.
Pose3 pose_across(const AnyJoint& joint, const double* q);
// A force on M at its origin, in the axes of M, with the generalized forces tau on the coordinates q.
Spatial::Force force_along(const AnyJoint& joint, const double* q, const double* tau);
void coordinate_rates(const AnyJoint& joint, const double* q, const double* v, double* qdot);

// Returns the joint as a joint of the spanning tree; reversed: F is on the outer body. Joints that are reversed by
// half a turn of their frames (reverses_by_turning()) are returned unchanged.
Stored<TreeJoint> tree_joint(const AnyJoint& joint, bool reversed);
// Whether half a turn of both frames about x exchanges the roles of F and M.
bool reverses_by_turning(const AnyJoint& joint);

// Returns R_UC, from the user's joint frame U to the frame C in which the axis of the joint is z (universal: a = x).
Eigen::Matrix3d canonical_rotation(const AnyJoint& joint, std::span<const Eigen::Vector3d> axes);

// Returns the signs by which q and v change if F and M are rotated by half a turn about x, which reverses the normal;
// all 1 unless the joint has PlanarRole::normal.
std::span<const double> flip_signs(const AnyJoint& joint);

}  // namespace gelenk
