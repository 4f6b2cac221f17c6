// SPDX-License-Identifier: BSD-3-Clause
// Constrained solutions by sparse factors, for many right-hand sides at a time.
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

// The component along a direction is stored in w at its pivot.
void SparseRowFactor::solve_constrained(double* w, const double* gamma, int columns, bool regularized) const {
  const int m = static_cast<int>(columns_.size());
  sum_.resize(columns);
  for (int k = 0; k < m; ++k) reflect(columns_[k], scale_[k], w, columns);
  for (int k = 0; k < m; ++k) {
    const Column& c = columns_[k];
    double* const x_k = columns::row(w, pivot(c), columns);
    std::copy_n(columns::row(gamma, order_[k], columns), columns, x_k);
    for (int i = c.first_above; i < c.first_above + c.above; ++i) {
      columns::add(-R_[i], columns::row(w, pivot(columns_[above_[i]]), columns), x_k, columns);
    }
    columns::scale((regularized ? equation_weight(relative_pivot(k), singular_threshold_) : 1) / diagonal_[k], x_k,
                   columns);
  }
  for (int k = m - 1; k >= 0; --k) reflect(columns_[k], scale_[k], w, columns);
}

}  // namespace gelenk
