// SPDX-License-Identifier: BSD-3-Clause
// Conversion of a spatial pose to the algebra A of a mechanism. In planar algebra z is the normal of the plane, and the
// position along it is dropped.
#pragma once

#include "math/planar.h"
#include "math/spatial.h"

namespace gelenk {

template <class A>
typename A::Pose pose_in(const Pose3& X) {
  using T = typename A::Scalar;
  if constexpr (A::planar) {
    return {T(X.R(0, 0)), T(X.R(1, 0)), T(X.p.x()), T(X.p.y())};
  } else {
    return {X.R.cast<T>(), X.p.cast<T>()};
  }
}

}  // namespace gelenk
