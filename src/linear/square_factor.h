// SPDX-License-Identifier: BSD-3-Clause
// LU factors of a small square matrix, by Gaussian elimination with row pivoting. For matrices of a few rows, of which
// libraries spend more time on calls than on numbers.
#pragma once

#include <cstddef>
#include <vector>

namespace gelenk {

class SquareFactor {
 public:
  explicit SquareFactor(int size = 0)
      : size_(size), values_(static_cast<std::size_t>(size) * size), pivots_(static_cast<std::size_t>(size)) {}

  int size() const { return size_; }
  // Row by row, before factorize().
  double& operator()(int r, int column) { return row(r)[column]; }

  // Returns the smallest pivot over the largest; 0: the matrix is singular. 1 for no rows.
  double factorize();
  // x <- the solution for the right-hand side x.
  void solve(double* x) const;

 private:
  double* row(int r) { return values_.data() + static_cast<std::size_t>(r) * size_; }
  const double* row(int r) const { return values_.data() + static_cast<std::size_t>(r) * size_; }

  int size_;
  std::vector<double> values_;
  std::vector<int> pivots_;  // by column: the row exchanged for it
};

}  // namespace gelenk
