// SPDX-License-Identifier: BSD-3-Clause
// What the rest of Gelenk may know of a kind of joint without knowing the joint: names, units, sizes.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "field/field.h"
#include "math/spatial.h"

namespace gelenk {

// One scalar of a joint. Elements of an array carry their index from 1, as in Modelica: "Q[1]".
struct Quantity {
  std::string_view name;
  std::string_view unit;         // SI, in FMI's spelling: "rad", "m/s2", "1"
  std::string_view description;  // completes "A: ..."
};

// How the axis of a joint must lie for the joint to move in a plane with normal n.
enum class PlanarRole {
  never,     // the joint leaves any plane
  normal,    // its axis is parallel to n
  in_plane,  // its axis lies in the plane
};

struct JointKind {
  std::string_view name;
  std::string_view summary;
  int nq = 0;    // coordinates
  int nv = 0;    // speeds = degrees of freedom
  int axes = 0;  // axes the user may give: 0, 1 (`axis`) or 2 (`axes`)
  PlanarRole planar = PlanarRole::never;
  std::span<const Quantity> q;      // nq coordinates
  std::span<const Quantity> v;      // nv speeds
  std::span<const Quantity> a;      // nv accelerations
  std::span<const double> q_zero;   // nq coordinates of the reference configuration, X_FM = 1
  std::span<const Field> fields{};  // its own numbers, as a screw's pitch

  // Springs need a coordinate whose rate is the speed: not the quaternion's.
  bool springs() const { return nq == nv && nv > 0; }
  bool stops() const { return nq == 1 && nv == 1; }
  bool has_quaternion() const { return nq > nv; }
};

}  // namespace gelenk
