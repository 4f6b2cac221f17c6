// SPDX-License-Identifier: BSD-3-Clause
// What has to hold beyond what joints do. A constraint is one of two kinds.
//
// Between coordinates of joints, sum of factor_i q_i = s, i running over its joint ports:
//   factor(i, on_base)    of the i-th; on_base(k): whether the k-th joint is on what the last one turns on
//   constant()            s, where it does not change
//   law()                 s as a function of time, if it has one
//   holds_position()      else the rates alone; follows_input(): s, or its rate, is its input
// may all be left out but factor().
//
// Between two bodies, which need not be joined: a NoCoordinates with rows as of a joint that closes a loop
// (joint/base.h), row_count of them, F on the second port, M on the first, with z along `axis`, a Direction, if it has
// one. Rows without position error have Phi = 0. Besides:
//   holds_position(i)     whether row i holds a position; else its rate alone; may be left out if all do
//   undefined(X_FM)       whether the rows are not defined there; may be left out, else there are as well
//   undefined_start()     what is wrong with a start there (ElementFault)
//   near_undefined(X_FM)  what ends a run near there, with {body} in it; empty elsewhere
//
// output(seen, group, i): component i of a group of its outputs, from what is seen of it: coordinate_force() [N m, N],
// contact_force(row) [N], X_WF(), X_FM().
#pragma once

#include <concepts>

#include "element/element.h"
#include "joint/base.h"

namespace gelenk {

// What constraints between bodies share: nothing moves at them by coordinates.
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
