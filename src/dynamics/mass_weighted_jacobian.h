// SPDX-License-Identifier: BSD-3-Clause
// The rows J of a mechanism, whitened by its mass and factorized: densely with sorted pivots where they are few or
// repeat each other, else without the zeros.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "dynamics/mass_factor.h"
#include "linear/row_factor.h"
#include "linear/sparse_row_factor.h"
#include "linear/sparse_rows.h"

namespace gelenk {

template <class A>
class MassWeightedJacobian {
 public:
  // M, J: outlive it.
  MassWeightedJacobian(const MassFactor<A>& M, const SparseRows& J, int speeds)
      : M_(M), J_(J), n_(speeds), m_(J.rows()), touched_(J.rows()) {
    for (int r = 0; r < m_; ++r) touched_[r] = M.inwards(J.speeds(r), J.entries(r));
    if (m_ >= fewest_sparse) {
      sparse_.emplace(n_, touched_);
      if (!sparse_->possible()) sparse_.reset();
    }
    if (!sparse_ || static_cast<double>(n_) * m_ < most_ready) dense_.emplace(n_, m_);
  }

  // See RowFactor; M at the same position.
  void factorize(int max_rank) {
    by_pattern_ = sparse_ && max_rank >= m_ && factorise_sparsely();
    if (by_pattern_) return;
    if (!dense_) dense_.emplace(n_, m_);
    dense_->set_weak(weak_);
    for (int r = 0; r < m_; ++r) {
      double* y = dense_->column(r);
      std::fill(y, y + n_, 0.0);
      J_.scatter(r, y);
      M_.solve_transposed(y, touched_[r]);
    }
    dense_->factorize(max_rank);
  }

  void set_weak(double weak) {
    weak_ = weak;
    if (sparse_) sparse_->set_weak(weak);
    if (dense_) dense_->set_weak(weak);
  }
  int rank() const { return by_pattern_ ? sparse_->rank() : dense_ ? dense_->rank() : 0; }
  double pivot_ratio() const { return by_pattern_ ? sparse_->pivot_ratio() : dense_ ? dense_->pivot_ratio() : 1; }
  void solve_constrained(double* w, const double* gamma, const double* extrapolated) const {
    by_pattern_ ? sparse_->solve_constrained(w, gamma, extrapolated)
                : dense_->solve_constrained(w, gamma, extrapolated);
  }
  // For the columns of w and gamma, see RowFactor.
  void solve_constrained(double* w, const double* gamma, int columns, bool regularized) const {
    by_pattern_ ? sparse_->solve_constrained(w, gamma, columns, regularized)
                : dense_->solve_constrained(w, gamma, columns, regularized);
  }
  void multipliers(double* lambda) const { by_pattern_ ? sparse_->multipliers(lambda) : dense_->multipliers(lambda); }
  void min_norm(const double* residual, double* w) const {
    by_pattern_ ? sparse_->min_norm(residual, w) : dense_->min_norm(residual, w);
  }

 private:
  // Rows: fewer are factorized densely. Without zeros to leave out, these many cost a quarter more than densely, but
  // the rows of mechanisms hardly ever touch all speeds; where they touch half of them, it is a tenth less.
  static constexpr int fewest_sparse = 8;
  static constexpr double most_ready = 1e6;  // numbers: more than these are asked of the heap when they are needed

  bool factorise_sparsely() {
    sparse_->begin();
    return std::ranges::all_of(sparse_->blocks(), [this](const SparseRowFactor::Block& block) {
      for (int i = 0; i < static_cast<int>(block.size()); ++i) {
        J_.scatter(block[i], sparse_->work(i));
        M_.solve_transposed(sparse_->work(i), touched_[block[i]]);
      }
      return sparse_->take(block);
    });
  }

  const MassFactor<A>& M_;
  const SparseRows& J_;
  int n_, m_;
  std::vector<std::vector<int>> touched_;  // by row: the speeds of its whitened column, ascending
  std::optional<RowFactor> dense_;
  std::optional<SparseRowFactor> sparse_;
  bool by_pattern_ = false;  // the last factorize() was without the zeros
  double weak_ = 0;
};

}  // namespace gelenk
