// SPDX-License-Identifier: BSD-3-Clause
#include "joint/registry.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "util/stored_impl.h"

namespace gelenk {
namespace {

template <class J>
std::span<const Field> fields_of() {
  if constexpr (requires { J::fields(); }) return J::fields();
  return {};
}

template <class J>
JointKind describe() {
  return {.name = J::kind,
          .summary = J::summary,
          .nq = J::nq,
          .nv = J::nv,
          .axes = J::axes,
          .planar = J::planar,
          .q = J::q_names,
          .v = J::v_names,
          .a = J::a_names,
          .q_zero = std::span<const double>(J::q_zero, J::nq),
          .fields = fields_of<J>()};
}

template <class... J>
auto describe_all(const std::variant<J...>*) {
  return std::array<JointKind, sizeof...(J)>{describe<J>()...};
}

template <class... J>
AnyJoint make_nth(std::size_t n, std::span<const Eigen::Vector3d> axes, const std::variant<J...>*) {
  using MakeJoint = AnyJoint (*)(std::span<const Eigen::Vector3d>);
  static constexpr std::array<MakeJoint, sizeof...(J)> makers = {
      [](std::span<const Eigen::Vector3d> given) { return AnyJoint(J::make(given)); }...};
  return makers.at(n)(axes);
}

template <class J>
TreeJoint outward(const J& joint, bool reversed) {
  if constexpr (!J::reverses_by_half_turn) {
    if (reversed) return Reversed<J>{joint};
  }
  return joint;
}

}  // namespace

std::span<const JointKind> joint_kinds() {
  static const auto kinds = describe_all(static_cast<const AnyJoint*>(nullptr));
  return kinds;
}

const JointKind* find_joint_kind(std::string_view name) {
  const auto kinds = joint_kinds();
  const auto found = std::ranges::find(kinds, name, &JointKind::name);
  return found == kinds.end() ? nullptr : &*found;
}

Stored<AnyJoint> make_joint(std::string_view kind, std::span<const Eigen::Vector3d> axes) {
  const JointKind* found = find_joint_kind(kind);
  if (found == nullptr) throw std::out_of_range("there is no joint type " + std::string(kind));
  const auto index = static_cast<std::size_t>(found - joint_kinds().data());
  return make_nth(index, axes, static_cast<const AnyJoint*>(nullptr));
}

std::vector<Eigen::Vector3d> default_axes(const JointKind& kind) {
  if (kind.axes == 2) return {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};
  return std::vector<Eigen::Vector3d>(static_cast<std::size_t>(kind.axes), Eigen::Vector3d::UnitZ());
}

template class Stored<AnyJoint>;
template class Stored<TreeJoint>;

void* data_of(AnyJoint& joint) {
  return std::visit([](auto& j) -> void* { return &j; }, joint);
}
const void* data_of(const AnyJoint& joint) {
  return std::visit([](const auto& j) -> const void* { return &j; }, joint);
}

const SwingLimit* swing_limit_of(const AnyJoint& joint) {
  return std::visit(
      [](const auto& j) -> const SwingLimit* {
        if constexpr (requires { j.limit->swing; }) {
          if (j.limit) return &*j.limit;
        }
        return nullptr;
      },
      joint);
}

std::vector<FrictionPart> friction_parts_of(const AnyJoint& joint) {
  return std::visit(
      [](const auto& j) -> std::vector<FrictionPart> {
        if constexpr (requires { j.friction_parts(); }) return j.friction_parts();
        return {};
      },
      joint);
}

std::optional<ElementFault> fault_of(const AnyJoint& joint) {
  return std::visit(
      [](const auto& j) -> std::optional<ElementFault> {
        if constexpr (requires { j.fault(); }) return j.fault();
        return {};
      },
      joint);
}

const JointKind& kind_of(const AnyJoint& joint) { return joint_kinds()[joint.index()]; }

Stored<TreeJoint> tree_joint(const AnyJoint& joint, bool reversed) {
  return std::visit([&](const auto& j) -> Stored<TreeJoint> { return outward(j, reversed); }, joint);
}

Pose3 pose_across(const AnyJoint& joint, const double* q) {
  return std::visit([&](const auto& j) { return j.template X_FM<Spatial>(q); }, joint);
}

Spatial::Force force_along(const AnyJoint& joint, const double* q, const double* tau) {
  return std::visit([&](const auto& j) { return j.template wrench_from_tau<Spatial>(q, tau); }, joint);
}

void coordinate_rates(const AnyJoint& joint, const double* q, const double* v, double* qdot) {
  std::visit([&](const auto& j) { j.qdot_from_v(q, v, qdot); }, joint);
}

bool reverses_by_turning(const AnyJoint& joint) {
  return std::visit([](const auto& j) { return j.reverses_by_half_turn; }, joint);
}

Eigen::Matrix3d canonical_rotation(const AnyJoint& joint, std::span<const Eigen::Vector3d> axes) {
  return std::visit([&](const auto& j) { return j.canonical(axes); }, joint);
}

std::span<const double> flip_signs(const AnyJoint& joint) {
  static constexpr std::array<double, 7> unchanged = {1, 1, 1, 1, 1, 1, 1};
  return std::visit(
      [](const auto& j) -> std::span<const double> {
        using J = std::decay_t<decltype(j)>;
        if constexpr (J::planar == PlanarRole::normal) {
          return {J::flip, J::nq};
        } else {
          return {unchanged.data(), J::nq};
        }
      },
      joint);
}

}  // namespace gelenk
