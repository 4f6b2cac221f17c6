// SPDX-License-Identifier: BSD-3-Clause
#include "dynamics/sparse_factor.h"

#include <cmath>
#include <utility>

namespace gelenk {

SparseFactor::SparseFactor(std::vector<int> parent)
    : n_(static_cast<int>(parent.size())), parent_(std::move(parent)), L_(parent_.size() * parent_.size(), 0.0) {}

int SparseFactor::factorise() {
  for (int k = n_ - 1; k >= 0; --k) {
    double* row_k = &L_[static_cast<std::size_t>(k) * n_];
    if (row_k[k] <= 0) return k;  // what is no number shows in the accelerations
    row_k[k] = std::sqrt(row_k[k]);
    const double inverse = 1 / row_k[k];
    for (int i = parent_[k]; i >= 0; i = parent_[i]) row_k[i] *= inverse;
    for (int i = parent_[k]; i >= 0; i = parent_[i]) {
      double* row_i = &L_[static_cast<std::size_t>(i) * n_];
      for (int j = i; j >= 0; j = parent_[j]) row_i[j] -= row_k[i] * row_k[j];
    }
  }
  return -1;
}

void SparseFactor::solve_transposed(double* x) const {
  for (int i = n_ - 1; i >= 0; --i) {
    const double* row = &L_[static_cast<std::size_t>(i) * n_];
    x[i] /= row[i];
    for (int j = parent_[i]; j >= 0; j = parent_[j]) x[j] -= row[j] * x[i];
  }
}

void SparseFactor::solve(double* x) const {
  for (int i = 0; i < n_; ++i) {
    const double* row = &L_[static_cast<std::size_t>(i) * n_];
    for (int j = parent_[i]; j >= 0; j = parent_[j]) x[i] -= row[j] * x[j];
    x[i] /= row[i];
  }
}

void SparseFactor::multiply(const double* x, double* y) const {
  for (int i = 0; i < n_; ++i) {
    const double* row = &L_[static_cast<std::size_t>(i) * n_];
    y[i] = 0;
    for (int j = i; j >= 0; j = parent_[j]) y[i] += row[j] * x[j];
  }
}

}  // namespace gelenk
