// SPDX-License-Identifier: BSD-3-Clause
// The interface of constraints beyond those of joints. There are two kinds of constraint.
//
// A constraint between coordinates of joints, sum of factor_i q_i = s over its joint ports i, has
//   factor(i, on_base)    factor of joint i; on_base(k): whether joint k has the same base body as the last joint
//   constant()            s, if it is constant
//   law()                 s as a function of time, if it is one
//   holds_position()      whether it constrains positions, not only their rates
//   follows_input()       whether s, or its rate, is its input
//   losses()              friction along joint 0 per force of the constraint on it, if it drives and if it is driven
// All except factor() are optional.
//
// A constraint between two bodies is derived from NoCoordinates and has constraint equations as a joint that closes a
// loop (joint/base.h), row_count of them, with F on the second port and M on the first, the z axis of M along the field
// `axis`, a Direction, if there is one. Equations without position error have Phi = 0. Optional functions:
//   prepared()            the same with what its equations need besides its fields
//   holds_position(i)     whether equation i constrains a position, not only its rate; by default true
//   undefined(X_FM)       whether the equations are undefined at this pose; if given, also the following three:
//   undefined_start()     the fault of a start at such a pose
//   near_undefined(X_FM)  the reason why a run ends near such a pose, with the placeholder {body}; empty elsewhere
//   distance_from_undefined<T>(X_FM)  a smooth number that is below 1 near such a pose
//
// output(seen, group, i): component i of an output group. seen offers coordinate_force() [N m, N],
// contact_force(row) [N], X_WF() and X_FM().
#pragma once

#include <concepts>

#include "element/element.h"
#include "joint/base.h"

namespace gelenk {

// Base class of constraints between bodies, which have no coordinates.
struct NoCoordinates {
  static constexpr PlanarRole planar = PlanarRole::never;
  static constexpr bool rows_turn = true;

  template <class A, class T>
  typename A::Motion bias(const T*, const T*) const {
    return {};
  }
  template <class A, class T>
  typename A::Force wrench_from_tau(const T*, const T*) const {
    return {};
  }
  template <class A, class T>
  void speeds(const T*, const typename A::Motion&, T*) const {}
  template <class A>
  void coordinates(const typename A::Pose&, typename A::Scalar*) const {}
};

template <class C>
concept BodyConstraint = std::derived_from<C, NoCoordinates>;

}  // namespace gelenk
