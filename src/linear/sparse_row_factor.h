// SPDX-License-Identifier: BSD-3-Clause
// The factorization of row_factor.h for many loops each of which depends on few velocities: sparse Y = Q R by
// Householder's method, with an ordering of the loops and a sparsity pattern that are computed once (George & Heath
// 1980; Davis 2006, ch. 5). Pivoting is within a loop, not among loops: an equation that depends on earlier ones has a
// small pivot of its own, and if a pivot is weak, the direction that its equation adds is weighted
// (set_singular_threshold()); later equations are then solved with that result.
#pragma once

#include <vector>

#include "linear/weak_pivots.h"

namespace gelenk {

class SparseRowFactor {
 public:
  // pattern: by constraint equation, the indices of the nonzeros in its column of Y, ascending.
  SparseRowFactor(int nv, const std::vector<std::vector<int>>& pattern);

  // Whether each equation has a pivot in the pattern; otherwise use RowFactor.
  bool is_applicable() const { return is_applicable_; }

  // Constraint equations with the same nonzeros, in the order of elimination.
  using Block = std::vector<int>;
  const std::vector<Block>& blocks() const { return blocks_; }
  // To factorize: begin(); then for each block write the nonzeros of its columns of Y into work(0), work(1), ... and
  // append() it. append() returns false if an equation is redundant; then use RowFactor.
  void begin() { rank_ = 0; }
  double* work(int i) { return x_.data() + static_cast<std::size_t>(i) * n_; }
  bool append(const Block& block);

  int rank() const { return rank_; }
  double pivot_ratio() const { return min_pivot_ / max_pivot_; }
  void set_singular_threshold(double threshold) { singular_threshold_ = threshold; }

  // See RowFactor.
  void solve_constrained(double* w, const double* gamma, const double* extrapolated) const;
  void solve_constrained(double* w, const double* gamma, int columns, bool regularized) const;
  void multipliers(double* lambda) const;
  void min_norm(const double* residual, double* w) const;

 private:
  struct Column {
    int first_row, rows;     // range of its Householder vector in rows_ and u_; the first entry is the pivot
    int first_above, above;  // range of R above the diagonal, in above_ and R_
  };

  void order_rows(const std::vector<std::vector<int>>& pattern);
  void analyze_pattern(const std::vector<std::vector<int>>& pattern);
  void reflect_row(int i);
  void choose_pivot(int k, int count);
  void reduce(int k, int count);
  double* remainder(int i) { return remainder_.data() + static_cast<std::size_t>(i) * max_remainder_; }
  double* above(int i) { return above_values_.data() + static_cast<std::size_t>(i) * max_above_; }
  int pivot(const Column& c) const { return rows_[c.first_row]; }
  void reflect(const Column& c, double scale, double* x) const;
  void reflect(const Column& c, double scale, double* x, int columns) const;
  double relative_pivot(int k) const { return diagonal_[k] / max_pivot_; }
  double component(int k, double value) const;

  int n_;
  bool is_applicable_ = true;
  std::vector<Block> blocks_;
  std::vector<int> order_;  // column k of R belongs to row order_[k]
  std::vector<Column> columns_;
  std::vector<int> rows_, above_;
  std::vector<double> u_, R_, diagonal_, scale_;
  int rank_ = 0;
  double max_pivot_ = 0, min_pivot_ = 0;  // by magnitude
  double singular_threshold_ = 0;
  // By equation of the current block: its column of Y; its part of R above the block; the remainder in the block.
  std::vector<double> x_, above_values_, remainder_;
  int max_above_ = 0, max_remainder_ = 0;
  mutable std::vector<double> d_, e_, f_;
  mutable std::vector<double> sum_;  // scratch memory for many columns
};

}  // namespace gelenk
