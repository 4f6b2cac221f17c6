// SPDX-License-Identifier: BSD-3-Clause
// A branch between two values that a number type may keep as such: numbers that record expressions
// (recording/recorded.h) have no values to decide by.
#pragma once

namespace gelenk {

// first() where g > 0, else second().
template <class T, class First, class Second>
T choose(const T& g, const First& first, const Second& second) {
  return g > T(0) ? T(first()) : T(second());
}

}  // namespace gelenk
