// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "math/spatial.h"

namespace gelenk {

// Against a velocity: -(damping + coefficient |v|) v.
template <class T>
Vector3<T> resistance(double damping, double coefficient, const Vector3<T>& v) {
  Vector3<T> out = T(-damping) * v;
  const T size = v.norm();
  if (size > T(0)) out -= T(coefficient) * size * v;  // at rest it and its derivative are 0
  return out;
}

}  // namespace gelenk
