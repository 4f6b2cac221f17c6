// SPDX-License-Identifier: BSD-3-Clause
#include "element/constraints/cut_joint.h"

#include <type_traits>

#include "util/stored_impl.h"

namespace gelenk {

template class Stored<CutJoint>;

Stored<CutJoint> cut_joint(const AnyJoint& joint) {
  return std::visit([](const auto& j) -> Stored<CutJoint> { return CutJoint(j); }, joint);
}

bool holds_position(const CutJoint& joint, int i) {
  return std::visit(
      [i](const auto& j) {
        if constexpr (requires { j.holds_position(i); }) return j.holds_position(i);
        return true;
      },
      joint);
}

int row_count(const CutJoint& joint) {
  return std::visit(
      [](const auto& j) -> int {
        if constexpr (BodyConstraint<std::decay_t<decltype(j)>>) return j.row_count;
        return 0;
      },
      joint);
}

bool is_undefined(const CutJoint& joint, const Pose3& X_FM) {
  return std::visit(
      [&](const auto& j) {
        if constexpr (requires { j.undefined(X_FM); }) return j.undefined(X_FM);
        return false;
      },
      joint);
}

bool can_be_undefined(const CutJoint& joint) {
  return std::visit([](const auto& j) { return requires(const Pose3& X) { j.undefined(X); }; }, joint);
}

ElementFault undefined_start(const CutJoint& joint) {
  return std::visit(
      [](const auto& j) -> ElementFault {
        if constexpr (requires { j.undefined_start(); }) return j.undefined_start();
        return {};
      },
      joint);
}

std::string_view near_undefined(const CutJoint& joint, const Pose3& X_FM) {
  return std::visit(
      [&](const auto& j) -> std::string_view {
        if constexpr (requires { j.near_undefined(X_FM); }) return j.near_undefined(X_FM);
        return {};
      },
      joint);
}

}  // namespace gelenk
