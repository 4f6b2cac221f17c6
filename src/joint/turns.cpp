// SPDX-License-Identifier: BSD-3-Clause
#include "joint/turns.h"

#include <numbers>
#include <variant>
#include <vector>

#include "joint/registry.h"

namespace gelenk {

bool repeats_each_turn(const AnyJoint& joint, int i) {
  constexpr double rounding = 1e-12;  // relative, of the position after a turn
  const JointKind& kind = kind_of(joint);
  if (kind.q[i].unit != "rad") return false;
  std::vector<double> q(kind.q_zero.begin(), kind.q_zero.end());
  return std::visit(
      [&](const auto& is) {
        const Pose3 X = is.template X_FM<Spatial>(q.data());
        q[i] += 2 * std::numbers::pi;
        return (is.template X_FM<Spatial>(q.data()).p - X.p).isZero(rounding);
      },
      joint);
}

}  // namespace gelenk
