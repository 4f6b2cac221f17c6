// SPDX-License-Identifier: BSD-3-Clause
// M = L^T L with L lower triangular, the factorisation that keeps the branches of the tree apart:
// L_ij is zero unless speed j lies on the way from speed i to the ground (Featherstone 2008, sec. 6.5).
#pragma once

#include <vector>

namespace gelenk {

class SparseFactor {
 public:
  // parent[i]: the speed before i on the way to the ground, -1 at the ground; parent[i] < i.
  explicit SparseFactor(std::vector<int> parent);

  int size() const { return n_; }
  // The lower triangle to be filled with M before factorise(): entry (i, j), j = i or an ancestor of i.
  double& at(int i, int j) { return L_[static_cast<std::size_t>(i) * n_ + j]; }
  double at(int i, int j) const { return L_[static_cast<std::size_t>(i) * n_ + j]; }

  // Returns -1, or the speed at which M has no inertia (pivot not positive beyond rounding).
  int factorise();

  void solve_transposed(double* x) const;           // x <- L^-T x: whitens a generalised force
  void solve(double* x) const;                      // x <- L^-1 x: from whitened to speeds
  void multiply(const double* x, double* y) const;  // y = L x: whitens speeds

 private:
  int n_;
  std::vector<int> parent_;
  std::vector<double> L_;
};

}  // namespace gelenk
