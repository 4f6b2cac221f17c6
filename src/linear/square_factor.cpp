// SPDX-License-Identifier: BSD-3-Clause
#include "linear/square_factor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gelenk {

// Rows that the pivot row does not change are left out: the loops of a mechanism are coupled by few of its velocities.
double SquareFactor::factorize() {
  double smallest = std::numeric_limits<double>::infinity();
  double largest = 0;
  for (int k = 0; k < size_; ++k) {
    double* const first = row(k);
    int pivot = k;
    for (int r = k + 1; r < size_; ++r) {
      if (std::abs(row(r)[k]) > std::abs(row(pivot)[k])) pivot = r;
    }
    pivots_[static_cast<std::size_t>(k)] = pivot;
    if (pivot != k) std::swap_ranges(first, first + size_, row(pivot));
    const double size = std::abs(first[k]);
    if (!(size > 0)) return 0;
    smallest = std::min(smallest, size);
    largest = std::max(largest, size);
    for (int r = k + 1; r < size_; ++r) {
      double* const other = row(r);
      if (other[k] == 0) continue;
      const double factor = other[k] /= first[k];
      for (int c = k + 1; c < size_; ++c) other[c] -= factor * first[c];
    }
  }
  return size_ == 0 ? 1 : smallest / largest;
}

void SquareFactor::solve(double* x) const {
  for (int k = 0; k < size_; ++k) std::swap(x[k], x[pivots_[static_cast<std::size_t>(k)]]);
  for (int r = 1; r < size_; ++r) {
    const double* const factors = row(r);
    for (int k = 0; k < r; ++k) x[r] -= factors[k] * x[k];
  }
  for (int r = size_ - 1; r >= 0; --r) {
    const double* const factors = row(r);
    for (int c = r + 1; c < size_; ++c) x[r] -= factors[c] * x[c];
    x[r] /= factors[r];
  }
}

}  // namespace gelenk
