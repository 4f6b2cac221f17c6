// SPDX-License-Identifier: BSD-3-Clause
// Rows of numbers that belong to many right sides.
#pragma once

namespace gelenk::columns {

// y += factor x
inline void add(double factor, const double* __restrict x, double* __restrict y, int n) {
  for (int i = 0; i < n; ++i) y[i] += factor * x[i];
}
inline void scale(double factor, double* x, int n) {
  for (int i = 0; i < n; ++i) x[i] *= factor;
}

}  // namespace gelenk::columns
