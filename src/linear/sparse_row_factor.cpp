// SPDX-License-Identifier: BSD-3-Clause
#include "linear/sparse_row_factor.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "linear/row_factor.h"

namespace gelenk {
namespace {

// By column in its order, the column that takes over what is left of it (Davis 2006, sec. 4.3); -1: none.
std::vector<int> elimination_tree(int speeds, const std::vector<std::vector<int>>& touched,
                                  const std::vector<int>& order) {
  const int m = static_cast<int>(order.size());
  std::vector<int> parent(m, -1);
  std::vector<int> root(m, -1);
  std::vector<int> last(speeds, -1);
  for (int j = 0; j < m; ++j) {
    for (const int i : touched[order[j]]) {
      for (int k = last[i]; k != -1 && k < j;) {
        const int next = root[k];
        root[k] = j;
        if (next == -1) parent[k] = j;
        k = next;
      }
      last[i] = j;
    }
  }
  return parent;
}

}  // namespace

SparseRowFactor::SparseRowFactor(int speeds, const std::vector<std::vector<int>>& touched)
    : n_(speeds), d_(speeds), e_(speeds), f_(touched.size()) {
  order_rows(touched);
  find_pattern(touched);
  std::size_t widest = 0;
  for (const Block& block : blocks_) widest = std::max(widest, block.size());
  for (const Column& c : columns_) {
    most_above_ = std::max(most_above_, c.above);
    left_rows_ = std::max(left_rows_, c.rows);
  }
  x_.assign(widest * n_, 0.0);
  above_values_.resize(widest * most_above_);
  left_.resize(widest * left_rows_);
}

void SparseRowFactor::order_rows(const std::vector<std::vector<int>>& touched) {
  std::vector<Block> blocks;
  for (int r = 0; r < static_cast<int>(touched.size()); ++r) {
    if (r == 0 || touched[r] != touched[r - 1]) blocks.emplace_back();
    blocks.back().push_back(r);
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    for (const int k : touched[blocks[i].front()]) entries.emplace_back(k, static_cast<int>(i), 1.0);
  }
  Eigen::SparseMatrix<double> Y(n_, static_cast<Eigen::Index>(blocks.size()));
  Y.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::COLAMDOrdering<int>()(Y, permutation);
  for (const int i : permutation.indices()) {
    blocks_.push_back(blocks[i]);
    order_.insert(order_.end(), blocks[i].begin(), blocks[i].end());
  }
}

void SparseRowFactor::find_pattern(const std::vector<std::vector<int>>& touched) {
  const int m = static_cast<int>(order_.size());
  const std::vector<int> parent = elimination_tree(n_, touched, order_);
  std::vector<int> leftmost(n_, -1);
  for (int j = m - 1; j >= 0; --j) {
    for (const int i : touched[order_[j]]) leftmost[i] = j;
  }
  std::vector<std::vector<int>> vectors(m);
  for (int i = 0; i < n_; ++i) {
    if (leftmost[i] >= 0) vectors[leftmost[i]].push_back(i);
  }
  std::vector<int> seen(m, -1);
  for (int j = 0; j < m; ++j) {
    Column column{static_cast<int>(rows_.size()), static_cast<int>(vectors[j].size()), static_cast<int>(above_.size()),
                  0};
    possible_ = possible_ && !vectors[j].empty();
    rows_.insert(rows_.end(), vectors[j].begin(), vectors[j].end());
    if (parent[j] >= 0 && !vectors[j].empty()) {
      vectors[parent[j]].insert(vectors[parent[j]].end(), vectors[j].begin() + 1, vectors[j].end());
    }
    for (const int i : touched[order_[j]]) {
      for (int k = leftmost[i]; k != -1 && k < j && seen[k] != j; k = parent[k]) {
        seen[k] = j;
        above_.push_back(k);
      }
    }
    std::sort(above_.begin() + column.first_above, above_.end());
    column.above = static_cast<int>(above_.size()) - column.first_above;
    columns_.push_back(column);
  }
  u_.resize(rows_.size());
  R_.resize(above_.size());
  diagonal_.resize(m);
  scale_.resize(m);
}

void SparseRowFactor::reflect(const Column& c, double scale, double* x) const {
  const int* row = rows_.data() + c.first_row;
  const double* u = u_.data() + c.first_row;
  double sum = 0;
  for (int i = 0; i < c.rows; ++i) sum += u[i] * x[row[i]];
  sum *= scale;
  for (int i = 0; i < c.rows; ++i) x[row[i]] -= sum * u[i];
}

// Of row i of the block: R above the block, and what is left in the rows of the block's first vector.
void SparseRowFactor::gather(int i) {
  const Column& c = columns_[taken_];
  double* x = work(i);
  for (int k = 0; k < c.above; ++k) {
    const int column = above_[c.first_above + k];
    reflect(columns_[column], scale_[column], x);
    double& value = x[pivot(columns_[column])];
    above(i)[k] = value;
    value = 0;
  }
  for (int k = 0; k < c.rows; ++k) {
    double& value = x[rows_[c.first_row + k]];
    left(i)[k] = value;
    value = 0;
  }
}

// Puts the row with the largest pivot at place k of the block.
void SparseRowFactor::sort(int k, int count) {
  const Column& c = columns_[taken_];
  int best = k;
  double most = -1;
  for (int i = k; i < count; ++i) {
    double square = 0;
    for (int r = k; r < c.rows; ++r) square += left(i)[r] * left(i)[r];
    if (square > most) {
      most = square;
      best = i;
    }
  }
  diagonal_[taken_ + k] = std::sqrt(most);
  if (best == k) return;
  std::swap(order_[taken_ + k], order_[taken_ + best]);
  std::swap_ranges(left(k), left(k) + c.rows, left(best));
  std::swap_ranges(above(k), above(k) + c.above, above(best));
}

// Householder's vector of the row at place k, and the rest of the block reflected by it.
void SparseRowFactor::reduce(int k, int count) {
  const int j = taken_ + k;
  const Column& c = columns_[j];
  double* R = R_.data() + c.first_above;
  std::copy_n(above(k), c.above - k, R);
  std::copy_n(left(k), k, R + c.above - k);
  double* u = u_.data() + c.first_row;
  std::copy_n(left(k) + k, c.rows, u);
  const double norm = diagonal_[j];
  scale_[j] = norm > 0 ? 1 / (norm * (norm + std::abs(u[0]))) : 0;
  if (u[0] > 0) diagonal_[j] = -norm;  // the sign that does not cancel
  u[0] -= diagonal_[j];
  for (int i = k + 1; i < count; ++i) {
    double* x = left(i) + k;
    double sum = 0;
    for (int r = 0; r < c.rows; ++r) sum += u[r] * x[r];
    sum *= scale_[j];
    for (int r = 0; r < c.rows; ++r) x[r] -= sum * u[r];
  }
  largest_ = j == 0 ? norm : std::max(largest_, norm);
  least_ = j == 0 ? norm : std::min(least_, norm);
}

bool SparseRowFactor::take(const Block& block) {
  const int count = static_cast<int>(block.size());
  for (int i = 0; i < count; ++i) gather(i);
  std::copy(block.begin(), block.end(), order_.begin() + taken_);
  for (int k = 0; k < count; ++k) {
    sort(k, count);
    reduce(k, count);
  }
  taken_ += count;
  return least_ > RowFactor::rank_threshold * largest_;
}

double SparseRowFactor::damping_weight(int k) const {
  if (weak_ == 0) return 1;
  const double p = diagonal_[k] / largest_;
  return p * p / (p * p + weak_ * weak_);
}

// The component along direction k that gives its row this value, after those before it in d_.
double SparseRowFactor::rest(int k, double value) const {
  const Column& c = columns_[k];
  for (int i = c.first_above; i < c.first_above + c.above; ++i) value -= R_[i] * d_[above_[i]];
  return value / diagonal_[k];
}

void SparseRowFactor::solve_constrained(double* w, const double* gamma, const double* extrapolated) const {
  const int m = static_cast<int>(columns_.size());
  for (int k = 0; k < m; ++k) reflect(columns_[k], scale_[k], w);
  if (extrapolated != nullptr) {
    std::copy(extrapolated, extrapolated + n_, e_.data());
    for (int k = 0; k < m; ++k) reflect(columns_[k], scale_[k], e_.data());
  }
  for (int k = 0; k < m; ++k) {
    double& along = w[pivot(columns_[k])];
    d_[k] = rest(k, gamma[order_[k]]);
    if (extrapolated != nullptr) d_[k] += (1 - damping_weight(k)) * (e_[pivot(columns_[k])] - d_[k]);
    f_[k] = along - d_[k];  // what the constraints take away
    along = d_[k];
  }
  for (int k = m - 1; k >= 0; --k) reflect(columns_[k], scale_[k], w);
}

void SparseRowFactor::multipliers(double* lambda) const {
  const int m = static_cast<int>(columns_.size());
  std::copy(f_.begin(), f_.end(), e_.begin());
  for (int k = m - 1; k >= 0; --k) {
    const Column& c = columns_[k];
    const double x = e_[k] / diagonal_[k];
    for (int i = c.first_above; i < c.first_above + c.above; ++i) e_[above_[i]] -= R_[i] * x;
    lambda[order_[k]] = x;
  }
}

void SparseRowFactor::min_norm(const double* residual, double* w) const {
  const int m = static_cast<int>(columns_.size());
  std::fill(w, w + n_, 0.0);
  for (int k = 0; k < m; ++k) w[pivot(columns_[k])] = d_[k] = damping_weight(k) * rest(k, residual[order_[k]]);
  for (int k = m - 1; k >= 0; --k) reflect(columns_[k], scale_[k], w);
}

}  // namespace gelenk
