// SPDX-License-Identifier: BSD-3-Clause
// What row_factor.h does, for many loops of which each touches few speeds: Y = Q R by Householder's method in an order
// of the loops and a pattern that are found once (George & Heath 1980; Davis 2006, ch. 5). Pivots are sorted within a
// loop, not among loops: a row that hangs on those before it shows in its own pivot, and where a pivot is weak, it is
// the direction that this row adds which is shared (set_weak); later rows are then met as it leaves them.
#pragma once

#include <vector>

namespace gelenk {

class SparseRowFactor {
 public:
  // touched: by row, the speeds of its column of Y, ascending.
  SparseRowFactor(int speeds, const std::vector<std::vector<int>>& touched);

  // Whether each row has a speed to be met by; false: of no use.
  bool possible() const { return possible_; }

  // Rows that touch the same speeds, in the order in which they are taken.
  using Block = std::vector<int>;
  const std::vector<Block>& blocks() const { return blocks_; }
  // To factorize: begin(); then for each block: write the columns of Y of its rows into work(0), work(1), ... where
  // they touch, and take() it. False: a row repeats those before it, and this class is of no use here.
  void begin() { taken_ = 0; }
  double* work(int i) { return x_.data() + static_cast<std::size_t>(i) * n_; }
  bool take(const Block& block);

  int rank() const { return taken_; }
  double pivot_ratio() const { return least_ / largest_; }
  void set_weak(double weak) { weak_ = weak; }

  // As RowFactor.
  void solve_constrained(double* w, const double* gamma, const double* extrapolated) const;
  void solve_constrained(double* w, const double* gamma, int columns, bool regularized) const;
  void multipliers(double* lambda) const;
  void min_norm(const double* residual, double* w) const;

 private:
  struct Column {
    int first_row, rows;     // of its Householder vector, in rows_ and u_; the first is its pivot
    int first_above, above;  // of R above the diagonal, in above_ and R_
  };

  void order_rows(const std::vector<std::vector<int>>& touched);
  void find_pattern(const std::vector<std::vector<int>>& touched);
  void gather(int i);
  void sort(int k, int count);
  void reduce(int k, int count);
  double* left(int i) { return left_.data() + static_cast<std::size_t>(i) * left_rows_; }
  double* above(int i) { return above_values_.data() + static_cast<std::size_t>(i) * most_above_; }
  int pivot(const Column& c) const { return rows_[c.first_row]; }
  void reflect(const Column& c, double scale, double* x) const;
  void reflect(const Column& c, double scale, double* x, int columns) const;
  double damping_weight(int k) const;
  double rest(int k, double value) const;

  int n_;
  bool possible_ = true;
  std::vector<Block> blocks_;
  std::vector<int> order_;  // column k of R belongs to row order_[k]
  std::vector<Column> columns_;
  std::vector<int> rows_, above_;
  std::vector<double> u_, R_, diagonal_, scale_;
  int taken_ = 0;
  double largest_ = 0, least_ = 0;  // pivots
  double weak_ = 0;
  // Of the block being taken, by its rows: columns of Y; R above the block; what is left of them in the block's rows.
  std::vector<double> x_, above_values_, left_;
  int most_above_ = 0, left_rows_ = 0;
  mutable std::vector<double> d_, e_, f_;
  mutable std::vector<double> sum_;  // of many columns
};

}  // namespace gelenk
