// SPDX-License-Identifier: BSD-3-Clause
// Description of a joint type for code that does not depend on particular joints: names, units, sizes.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "field/field.h"
#include "math/spatial.h"

namespace gelenk {

// A scalar variable of a joint. Names of array elements contain the index, from 1, as in Modelica: "Q[1]".
struct Quantity {
  std::string_view name;
  std::string_view unit;         // SI, in FMI's spelling: "rad", "m/s2", "1"
  std::string_view description;  // completes "A: ..."
};

// Direction that the axis of a joint must have for a motion in a plane with normal n.
enum class PlanarRole {
  never,     // the joint has no planar motion
  normal,    // its axis is parallel to n
  in_plane,  // its axis is parallel to the plane
};

struct JointKind {
  std::string_view name;
  std::string_view summary;
  int nq = 0;    // coordinates
  int nv = 0;    // velocities = degrees of freedom
  int axes = 0;  // axes in the scene file: 0, 1 (`axis`) or 2 (`axes`)
  PlanarRole planar = PlanarRole::never;
  std::span<const Quantity> q;      // nq coordinates
  std::span<const Quantity> v;      // nv velocities
  std::span<const Quantity> a;      // nv accelerations
  std::span<const double> q_zero;   // nq coordinates of the reference configuration, X_FM = 1
  std::span<const Field> fields{};  // parameters of the joint, such as the pitch of a screw

  // Whether its coordinates can have springs, friction and limits: only if qdot = v, hence no quaternions.
  bool springs() const { return nq == nv && nv > 0; }
  bool has_quaternion() const { return nq > nv; }
  // Whether coordinate i is a component of the quaternion, and velocity i one of its angular velocity; both come last.
  // Any other velocity i is the time derivative of coordinate i.
  bool is_of_quaternion(int i) const { return has_quaternion() && i >= nq - 4; }
};

}  // namespace gelenk
