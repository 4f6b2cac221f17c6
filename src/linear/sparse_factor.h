// SPDX-License-Identifier: BSD-3-Clause
// M = L^T L with L lower triangular, the factorization without fill-in between the branches of the tree:
// L_ij is zero unless velocity j lies on the path from velocity i to the ground (Featherstone 2008, sec. 6.5).
#pragma once

#include <span>
#include <vector>

namespace gelenk {

class SparseFactor {
 public:
  // parent[i]: the next velocity on the path from i to the ground, -1 at the ground; parent[i] < i.
  explicit SparseFactor(const std::vector<int>& parent);

  int size() const { return static_cast<int>(depth_.size()); }
  // Row i, to be filled with M before factorize(): its entries from the ground outward, the diagonal last.
  double* row(int i) { return L_.data() + first_[i]; }
  const double* row(int i) const { return L_.data() + first_[i]; }
  // Number of velocities between i and the ground. The entry of an ancestor in row i is at index depth(ancestor).
  int depth(int i) const { return depth_[i]; }
  // The column indices of the entries of row i.
  const int* ancestors(int i) const { return ancestors_.data() + first_[i]; }

  // Returns -1, or the velocity at which M has no inertia (its pivot is not positive).
  int factorize();

  // If factorize() failed at velocity k, or its pivot is rounding: z with z[k] = 1 and zeros before k, such that
  // M z = 0 in the rows from k on.
  void null_motion(int k, double* z) const;

  void solve_transposed(double* x) const;  // x <- L^-T x: whitens a generalized force
  // The same for a sparse x. nonzeros: its indices, ascending and with all ancestors of each.
  void solve_transposed(double* x, std::span<const int> nonzeros) const;
  void solve(double* x) const;                      // x <- L^-1 x: from whitened to generalized velocities
  void multiply(const double* x, double* y) const;  // y = L x: whitens generalized velocities
  // The same for each column of x (size() x columns), stored row by row.
  void solve_transposed(double* x, int columns) const;
  void solve(double* x, int columns) const;

 private:
  void carry_inwards(int i, double* x) const;

  std::vector<int> depth_;
  std::vector<int> first_;      // start of each row in ancestors_ and L_
  std::vector<int> ancestors_;  // by row, from the ground outward; the velocity itself last
  std::vector<double> L_;
  std::vector<double> inverse_;  // of the diagonal
};

}  // namespace gelenk
