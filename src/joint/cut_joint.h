// SPDX-License-Identifier: BSD-3-Clause
// What may close a loop.
#pragma once

#include <variant>

#include "joint/contact.h"
#include "joint/rod.h"

namespace gelenk {

// The order of AnyJoint, then what no scene names as a joint.
using CutJoint = std::variant<Revolute, Prismatic, Spherical, Universal, Cylindrical, PlanarJoint, Free, Weld, Rod,
                              Rolling, KnifeEdge>;

inline CutJoint cut_joint(const AnyJoint& joint) {
  return std::visit([](const auto& j) { return CutJoint(j); }, joint);
}

// Whether the joint's row i holds positions; else it holds their rates alone (non-holonomic).
inline bool holds_position(const CutJoint& joint, int i) {
  if (std::holds_alternative<KnifeEdge>(joint)) return false;
  return !std::holds_alternative<Rolling>(joint) || i == 0;
}

// Whether it is a wheel that lies flat on its plane.
inline bool lies_flat(const CutJoint& joint, const Pose3& X_FM) {
  return std::holds_alternative<Rolling>(joint) && Rolling::lies_flat(X_FM);
}

}  // namespace gelenk
