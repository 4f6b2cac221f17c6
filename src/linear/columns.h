// SPDX-License-Identifier: BSD-3-Clause
// Operations on matrices whose columns are many right-hand sides, stored row by row.
#pragma once

#include <cstddef>

namespace gelenk::columns {

// Row i of the matrix x with this many columns.
template <class Number>
Number* row(Number* x, int i, int columns) {
  return x + static_cast<std::size_t>(i) * columns;
}

// y += factor x
inline void add(double factor, const double* __restrict x, double* __restrict y, int n) {
  for (int i = 0; i < n; ++i) y[i] += factor * x[i];
}
// x *= factor
inline void scale(double factor, double* x, int n) {
  for (int i = 0; i < n; ++i) x[i] *= factor;
}

}  // namespace gelenk::columns
