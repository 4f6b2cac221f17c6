// SPDX-License-Identifier: BSD-3-Clause
// Constrained solutions for many right-hand sides at a time.
#include <algorithm>

#include "linear/columns.h"
#include "linear/row_factor.h"

namespace gelenk {
namespace {

// x -= scale u (u^T x), with x (rows x n) stored row by row. sum: n numbers of scratch memory.
void reflect_rows(const double* u, double scale, double* x, int rows, int n, double* sum) {
  std::fill(sum, sum + n, 0.0);
  for (int i = 0; i < rows; ++i) columns::add(u[i], x + static_cast<std::size_t>(i) * n, sum, n);
  for (int i = 0; i < rows; ++i) columns::add(-scale * u[i], sum, x + static_cast<std::size_t>(i) * n, n);
}

}  // namespace

void RowFactor::solve_constrained(double* w, const double* gamma, int columns, bool regularized) const {
  columns_.resize(static_cast<std::size_t>(m_ + 1) * columns);
  double* const d = columns_.data();
  double* const sum = d + static_cast<std::size_t>(m_) * columns;
  const auto row = [columns](auto* x, int i) { return x + static_cast<std::size_t>(i) * columns; };
  solve_Rt(gamma, columns, d, sum);
  for (int k = 0; k < rank_; ++k) {
    reflect_rows(&Y_[static_cast<std::size_t>(k) * n_] + k, scale_[k], row(w, k), n_ - k, columns, sum);
  }
  for (int k = 0; k < rank_; ++k) {
    const double s = regularized ? equation_weight(relative_pivot(k), singular_threshold_) : 1;
    for (int c = 0; c < columns; ++c) row(w, k)[c] = s * row(d, k)[c];
  }
  for (int k = rank_ - 1; k >= 0; --k) {
    reflect_rows(&Y_[static_cast<std::size_t>(k) * n_] + k, scale_[k], row(w, k), n_ - k, columns, sum);
  }
}

void RowFactor::solve_Rt(const double* in, int columns, double* d, double* sum) const {
  const auto row = [columns](auto* x, int i) { return x + static_cast<std::size_t>(i) * columns; };
  for (int k = 0; k < m_; ++k) std::copy_n(row(in, order_[k]), columns, row(d, k));
  if (rank_ == m_) {
    for (int k = 0; k < rank_; ++k) {
      const double* r = &Y_[static_cast<std::size_t>(k) * n_];
      for (int j = 0; j < k; ++j) columns::add(-r[j], row(d, j), row(d, k), columns);
      columns::scale(1 / diagonal_[k], row(d, k), columns);
    }
    return;
  }
  for (int k = 0; k < rank_; ++k) {
    reflect_rows(&Z_[static_cast<std::size_t>(k) * m_] + k, Z_scale_[k], row(d, k), m_ - k, columns, sum);
  }
  for (int k = rank_ - 1; k >= 0; --k) {
    for (int j = k + 1; j < rank_; ++j) {
      columns::add(-Z_[static_cast<std::size_t>(j) * m_ + k], row(d, j), row(d, k), columns);
    }
    columns::scale(1 / T_diagonal_[k], row(d, k), columns);
  }
}

}  // namespace gelenk
