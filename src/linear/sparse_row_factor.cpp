// SPDX-License-Identifier: BSD-3-Clause
#include "linear/sparse_row_factor.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "linear/row_factor.h"

namespace gelenk {
namespace {

// By column in elimination order: the parent in the column elimination tree (Davis 2006, sec. 4.3), or -1.
std::vector<int> elimination_tree(int nv, const std::vector<std::vector<int>>& pattern, const std::vector<int>& order) {
  const int m = static_cast<int>(order.size());
  std::vector<int> parent(m, -1);
  std::vector<int> root(m, -1);
  std::vector<int> last_column(nv, -1);
  for (int j = 0; j < m; ++j) {
    for (const int i : pattern[order[j]]) {
      for (int k = last_column[i]; k != -1 && k < j;) {
        const int next = root[k];
        root[k] = j;
        if (next == -1) parent[k] = j;
        k = next;
      }
      last_column[i] = j;
    }
  }
  return parent;
}

}  // namespace

SparseRowFactor::SparseRowFactor(int nv, const std::vector<std::vector<int>>& pattern)
    : n_(nv), d_(nv), e_(nv), f_(pattern.size()) {
  order_rows(pattern);
  analyze_pattern(pattern);
  std::size_t max_block_size = 0;
  for (const Block& block : blocks_) max_block_size = std::max(max_block_size, block.size());
  for (const Column& c : columns_) {
    max_above_ = std::max(max_above_, c.above);
    max_remainder_ = std::max(max_remainder_, c.rows);
  }
  x_.assign(max_block_size * n_, 0.0);
  above_values_.resize(max_block_size * max_above_);
  remainder_.resize(max_block_size * max_remainder_);
}

void SparseRowFactor::order_rows(const std::vector<std::vector<int>>& pattern) {
  std::vector<Block> blocks;
  for (int r = 0; r < static_cast<int>(pattern.size()); ++r) {
    if (r == 0 || pattern[r] != pattern[r - 1]) blocks.emplace_back();
    blocks.back().push_back(r);
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    for (const int k : pattern[blocks[i].front()]) entries.emplace_back(k, static_cast<int>(i), 1.0);
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

void SparseRowFactor::analyze_pattern(const std::vector<std::vector<int>>& pattern) {
  const int m = static_cast<int>(order_.size());
  const std::vector<int> parent = elimination_tree(n_, pattern, order_);
  std::vector<int> leftmost(n_, -1);
  for (int j = m - 1; j >= 0; --j) {
    for (const int i : pattern[order_[j]]) leftmost[i] = j;
  }
  std::vector<std::vector<int>> vectors(m);
  for (int i = 0; i < n_; ++i) {
    if (leftmost[i] >= 0) vectors[leftmost[i]].push_back(i);
  }
  std::vector<int> visited(m, -1);
  for (int j = 0; j < m; ++j) {
    Column column{static_cast<int>(rows_.size()), static_cast<int>(vectors[j].size()), static_cast<int>(above_.size()),
                  0};
    is_applicable_ = is_applicable_ && !vectors[j].empty();
    rows_.insert(rows_.end(), vectors[j].begin(), vectors[j].end());
    if (parent[j] >= 0 && !vectors[j].empty()) {
      vectors[parent[j]].insert(vectors[parent[j]].end(), vectors[j].begin() + 1, vectors[j].end());
    }
    for (const int i : pattern[order_[j]]) {
      for (int k = leftmost[i]; k != -1 && k < j && visited[k] != j; k = parent[k]) {
        visited[k] = j;
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

// Equation i of the block: computes its part of R above the block, and the remainder in the rows of the first vector.
void SparseRowFactor::reflect_row(int i) {
  const Column& c = columns_[rank_];
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
    remainder(i)[k] = value;
    value = 0;
  }
}

// Moves the equation with the largest pivot to position k of the block.
void SparseRowFactor::choose_pivot(int k, int count) {
  const Column& c = columns_[rank_];
  int best = k;
  double max_square = -1;
  for (int i = k; i < count; ++i) {
    double square = 0;
    for (int r = k; r < c.rows; ++r) square += remainder(i)[r] * remainder(i)[r];
    if (square > max_square) {
      max_square = square;
      best = i;
    }
  }
  diagonal_[rank_ + k] = std::sqrt(max_square);
  if (best == k) return;
  std::swap(order_[rank_ + k], order_[rank_ + best]);
  std::swap_ranges(remainder(k), remainder(k) + c.rows, remainder(best));
  std::swap_ranges(above(k), above(k) + c.above, above(best));
}

// Computes the Householder vector of the equation at position k, and reflects the rest of the block by it.
void SparseRowFactor::reduce(int k, int count) {
  const int j = rank_ + k;
  const Column& c = columns_[j];
  double* R = R_.data() + c.first_above;
  std::copy_n(above(k), c.above - k, R);
  std::copy_n(remainder(k), k, R + c.above - k);
  double* u = u_.data() + c.first_row;
  std::copy_n(remainder(k) + k, c.rows, u);
  const double norm = diagonal_[j];
  scale_[j] = norm > 0 ? 1 / (norm * (norm + std::abs(u[0]))) : 0;
  if (u[0] > 0) diagonal_[j] = -norm;  // the sign that does not cancel
  u[0] -= diagonal_[j];
  for (int i = k + 1; i < count; ++i) {
    double* x = remainder(i) + k;
    double sum = 0;
    for (int r = 0; r < c.rows; ++r) sum += u[r] * x[r];
    sum *= scale_[j];
    for (int r = 0; r < c.rows; ++r) x[r] -= sum * u[r];
  }
  max_pivot_ = j == 0 ? norm : std::max(max_pivot_, norm);
  min_pivot_ = j == 0 ? norm : std::min(min_pivot_, norm);
}

bool SparseRowFactor::append(const Block& block) {
  const int count = static_cast<int>(block.size());
  for (int i = 0; i < count; ++i) reflect_row(i);
  std::copy(block.begin(), block.end(), order_.begin() + rank_);
  for (int k = 0; k < count; ++k) {
    choose_pivot(k, count);
    reduce(k, count);
  }
  rank_ += count;
  return min_pivot_ > RowFactor::rank_threshold * max_pivot_;
}

// The component along direction k that gives its equation this value, with the earlier components in d_.
double SparseRowFactor::component(int k, double value) const {
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
    double& x_k = w[pivot(columns_[k])];
    d_[k] = component(k, gamma[order_[k]]);
    if (extrapolated != nullptr)
      d_[k] += (1 - equation_weight(relative_pivot(k), singular_threshold_)) * (e_[pivot(columns_[k])] - d_[k]);
    f_[k] = x_k - d_[k];  // what the constraints remove
    x_k = d_[k];
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
  for (int k = 0; k < m; ++k)
    w[pivot(columns_[k])] = d_[k] =
        damping_weight(relative_pivot(k), singular_threshold_) * component(k, residual[order_[k]]);
  for (int k = m - 1; k >= 0; --k) reflect(columns_[k], scale_[k], w);
}

}  // namespace gelenk
