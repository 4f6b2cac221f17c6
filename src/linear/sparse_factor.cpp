// SPDX-License-Identifier: BSD-3-Clause
#include "linear/sparse_factor.h"

#include <cmath>

#include "linear/columns.h"

namespace gelenk {

SparseFactor::SparseFactor(const std::vector<int>& parent) {
  for (int i = 0; i < static_cast<int>(parent.size()); ++i) {
    depth_.push_back(parent[i] < 0 ? 0 : depth_[parent[i]] + 1);
    first_.push_back(static_cast<int>(ancestors_.size()));
    for (int d = 0; d < depth_[i]; ++d) {
      const int ancestor = ancestors_[first_[parent[i]] + d];
      ancestors_.push_back(ancestor);
    }
    ancestors_.push_back(i);
  }
  L_.assign(ancestors_.size(), 0.0);
  inverse_.assign(depth_.size(), 0.0);
}

int SparseFactor::factorize() {
  for (int k = size() - 1; k >= 0; --k) {
    double* row_k = row(k);
    const int depth = depth_[k];
    if (row_k[depth] <= 0) return k;  // NaN passes and shows up in the accelerations
    row_k[depth] = std::sqrt(row_k[depth]);
    const double inverse = 1 / row_k[depth];
    inverse_[k] = inverse;
    for (int d = 0; d < depth; ++d) row_k[d] *= inverse;
    const int* inner = ancestors(k);
    for (int d = 0; d < depth; ++d) {
      double* __restrict row_i = row(inner[d]);
      const double* __restrict factors = row_k;
      const double factor = factors[d];
      for (int e = 0; e <= d; ++e) row_i[e] -= factor * factors[e];
    }
  }
  return -1;
}

void SparseFactor::null_motion(int k, double* z) const {
  for (int i = 0; i < size(); ++i) {
    z[i] = i == k ? 1 : 0;
    if (i <= k) continue;
    const double* L = row(i);
    const int* inner = ancestors(i);
    for (int d = 0; d < depth_[i]; ++d) z[i] -= L[d] * z[inner[d]];
    z[i] *= inverse_[i];
  }
}

inline void SparseFactor::carry_inwards(int i, double* x) const {
  const double* L = row(i);
  const int* inner = ancestors(i);
  const int depth = depth_[i];
  x[i] *= inverse_[i];
  for (int d = 0; d < depth; ++d) x[inner[d]] -= L[d] * x[i];
}

void SparseFactor::solve_transposed(double* x) const {
  for (int i = size() - 1; i >= 0; --i) carry_inwards(i, x);
}

void SparseFactor::solve_transposed(double* x, std::span<const int> nonzeros) const {
  for (auto i = nonzeros.rbegin(); i != nonzeros.rend(); ++i) carry_inwards(*i, x);
}

void SparseFactor::solve(double* x) const {
  for (int i = 0; i < size(); ++i) {
    const double* L = row(i);
    const int* inner = ancestors(i);
    const int depth = depth_[i];
    double sum = x[i];
    for (int d = 0; d < depth; ++d) sum -= L[d] * x[inner[d]];
    x[i] = sum * inverse_[i];
  }
}

void SparseFactor::solve_transposed(double* x, int columns) const {
  for (int i = size() - 1; i >= 0; --i) {
    const double* L = row(i);
    const int* inner = ancestors(i);
    double* const x_i = x + static_cast<std::size_t>(i) * columns;
    columns::scale(inverse_[i], x_i, columns);
    for (int d = 0; d < depth_[i]; ++d) {
      columns::add(-L[d], x_i, x + static_cast<std::size_t>(inner[d]) * columns, columns);
    }
  }
}

void SparseFactor::solve(double* x, int columns) const {
  for (int i = 0; i < size(); ++i) {
    const double* L = row(i);
    const int* inner = ancestors(i);
    double* const x_i = x + static_cast<std::size_t>(i) * columns;
    for (int d = 0; d < depth_[i]; ++d) {
      columns::add(-L[d], x + static_cast<std::size_t>(inner[d]) * columns, x_i, columns);
    }
    columns::scale(inverse_[i], x_i, columns);
  }
}

void SparseFactor::multiply(const double* x, double* y) const {
  for (int i = 0; i < size(); ++i) {
    const double* L = row(i);
    const int* inner = ancestors(i);
    y[i] = 0;
    for (int d = depth_[i]; d >= 0; --d) y[i] += L[d] * x[inner[d]];
  }
}

}  // namespace gelenk
