// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "math/spatial.h"

namespace gelenk {

// Force or torque opposite to a velocity v: -(damping + coefficient |v|) v.
template <class T>
Vector3<T> resistance(double damping, double coefficient, const Vector3<T>& v) {
  Vector3<T> out = T(-damping) * v;
  const T speed = v.norm();
  if (speed > T(0)) out -= T(coefficient) * speed * v;  // at rest this term and its derivative are 0
  return out;
}

}  // namespace gelenk
