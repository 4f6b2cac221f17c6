// SPDX-License-Identifier: BSD-3-Clause
// M = L^T L with L lower triangular, the factorisation that keeps the branches of the tree apart:
// L_ij is zero unless speed j lies on the way from speed i to the ground (Featherstone 2008, sec. 6.5).
#pragma once

#include <vector>

namespace gelenk {

class SparseFactor {
 public:
  // parent[i]: the speed before i on the way to the ground, -1 at the ground; parent[i] < i.
  explicit SparseFactor(const std::vector<int>& parent);

  int size() const { return static_cast<int>(depth_.size()); }
  // Row i, to be filled with M before factorize(): its entries with the speeds from the ground outwards, itself last.
  double* row(int i) { return L_.data() + first_[i]; }
  const double* row(int i) const { return L_.data() + first_[i]; }
  // Speeds between i and the ground; the place of an ancestor's entry in row i is the ancestor's own depth.
  int depth(int i) const { return depth_[i]; }
  // The speeds to which the entries of row i belong.
  const int* ancestors(int i) const { return ancestors_.data() + first_[i]; }

  // Returns -1, or the speed at which M has no inertia (pivot not positive beyond rounding).
  int factorize();

  // Where factorize() ended at speed k, or its pivot is rounding: z, with z[k] = 1 and zeros before k, of M z = 0 in
  // the rows from k on.
  void null_motion(int k, double* z) const;

  void solve_transposed(double* x) const;  // x <- L^-T x: whitens a generalised force
  // The same for an x with zeros but at these speeds, ascending, which hold all speeds inwards of each.
  void solve_transposed(double* x, const std::vector<int>& speeds) const;
  void solve(double* x) const;                      // x <- L^-1 x: from whitened to speeds
  void multiply(const double* x, double* y) const;  // y = L x: whitens speeds
  // The same for the columns of x, which is stored row by row.
  void solve_transposed(double* x, int columns) const;
  void solve(double* x, int columns) const;

 private:
  void carry_inwards(int i, double* x) const;

  std::vector<int> depth_;
  std::vector<int> first_;      // of each row in what follows
  std::vector<int> ancestors_;  // by row, from the ground outwards; the speed itself last
  std::vector<double> L_;
  std::vector<double> inverse_;  // of the diagonal
};

}  // namespace gelenk
