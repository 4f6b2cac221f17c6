// SPDX-License-Identifier: BSD-3-Clause
// The rows' equations without their zeros, for many right sides at a time.
#include <algorithm>

#include "linear/columns.h"
#include "linear/sparse_row_factor.h"

namespace gelenk {

void SparseRowFactor::reflect(const Column& c, double scale, double* x, int columns) const {
  const int* row = rows_.data() + c.first_row;
  const double* u = u_.data() + c.first_row;
  std::fill_n(sum_.data(), columns, 0.0);
  for (int i = 0; i < c.rows; ++i) columns::add(u[i], columns::row(x, row[i], columns), sum_.data(), columns);
  for (int i = 0; i < c.rows; ++i) columns::add(-scale * u[i], sum_.data(), columns::row(x, row[i], columns), columns);
}

// A direction's component stands in w where its pivot is.
void SparseRowFactor::solve_constrained(double* w, const double* gamma, int columns, bool regularized) const {
  const int m = static_cast<int>(columns_.size());
  sum_.resize(columns);
  for (int k = 0; k < m; ++k) reflect(columns_[k], scale_[k], w, columns);
  for (int k = 0; k < m; ++k) {
    const Column& c = columns_[k];
    double* const along = columns::row(w, pivot(c), columns);
    std::copy_n(columns::row(gamma, order_[k], columns), columns, along);
    for (int i = c.first_above; i < c.first_above + c.above; ++i) {
      columns::add(-R_[i], columns::row(w, pivot(columns_[above_[i]]), columns), along, columns);
    }
    columns::scale((regularized ? damping_weight(k) : 1) / diagonal_[k], along, columns);
  }
  for (int k = m - 1; k >= 0; --k) reflect(columns_[k], scale_[k], w, columns);
}

}  // namespace gelenk
