// SPDX-License-Identifier: BSD-3-Clause
#include "element/constraints/cut_joint.h"

#include <type_traits>

#include "util/stored_impl.h"

namespace gelenk {

CutJoint::CutJoint() = default;
CutJoint::CutJoint(const CutJoint& other) = default;
CutJoint::CutJoint(CutJoint&& other) noexcept = default;
CutJoint& CutJoint::operator=(const CutJoint& other) = default;
CutJoint& CutJoint::operator=(CutJoint&& other) noexcept = default;
CutJoint::~CutJoint() = default;

template class Stored<CutJoint>;

Stored<CutJoint> cut_joint(const AnyJoint& joint) {
  return std::visit([](const auto& j) -> Stored<CutJoint> { return CutJoint(j); }, joint);
}

namespace {

// visit(c) of a constraint between bodies; for a joint: otherwise.
template <class Result, class Visit>
Result of_constraint(const CutJoint& joint, const Result& otherwise, Visit visit) {
  const auto* const constraint = std::get_if<AnyBodyConstraint>(&joint);
  return constraint == nullptr ? otherwise : std::visit(visit, constraint->is);
}

}  // namespace

bool holds_position(const CutJoint& joint, int i) {
  return of_constraint(joint, true, [i](const auto& c) {
    if constexpr (requires { c.holds_position(i); }) return c.holds_position(i);
    return true;
  });
}

int row_count(const CutJoint& joint) {
  return of_constraint(joint, 0, [](const auto& c) { return c.row_count; });
}

bool is_undefined(const CutJoint& joint, const Pose3& X_FM) {
  return of_constraint(joint, false, [&](const auto& c) {
    if constexpr (requires { c.undefined(X_FM); }) return c.undefined(X_FM);
    return false;
  });
}

bool can_be_undefined(const CutJoint& joint) {
  return of_constraint(joint, false, [](const auto& c) { return requires(const Pose3& X) { c.undefined(X); }; });
}

ElementFault undefined_start(const CutJoint& joint) {
  return of_constraint(joint, ElementFault(), [](const auto& c) {
    if constexpr (requires { c.undefined_start(); }) return c.undefined_start();
    return ElementFault();
  });
}

std::string_view near_undefined(const CutJoint& joint, const Pose3& X_FM) {
  return of_constraint(joint, std::string_view(), [&](const auto& c) {
    if constexpr (requires { c.near_undefined(X_FM); }) return c.near_undefined(X_FM);
    return std::string_view();
  });
}

}  // namespace gelenk
