// SPDX-License-Identifier: BSD-3-Clause
// The mass-weighted ("whitened") constraint Jacobian L^-T J^T and its factorization: dense with column pivoting for few
// or redundant constraint equations, otherwise sparse.
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
  // M and J must outlive it.
  MassWeightedJacobian(const MassFactor<A>& M, const SparseRows& J, int nv)
      : M_(M), J_(J), n_(nv), m_(J.rows()), pattern_(J.rows()) {
    for (int r = 0; r < m_; ++r) pattern_[r] = M.inwards(J.columns(r), J.entries(r));
    if (m_ >= min_sparse_rows) {
      sparse_.emplace(n_, pattern_);
      if (!sparse_->is_applicable()) sparse_.reset();
    }
    if (!sparse_ || static_cast<double>(n_) * m_ < max_preallocated_size) dense_.emplace(n_, m_);
  }

  // See RowFactor. M must have been factorized at the same position.
  void factorize(int max_rank) {
    by_pattern_ = sparse_ && max_rank >= m_ && factorize_sparsely();
    if (by_pattern_) return;
    if (!dense_) dense_.emplace(n_, m_);
    dense_->set_singular_threshold(singular_threshold_);
    for (int r = 0; r < m_; ++r) {
      double* y = dense_->column(r);
      std::fill(y, y + n_, 0.0);
      J_.scatter(r, y);
      M_.solve_transposed(y, pattern_[r]);
    }
    dense_->factorize(max_rank);
  }

  void set_singular_threshold(double weak) {
    singular_threshold_ = weak;
    if (sparse_) sparse_->set_singular_threshold(weak);
    if (dense_) dense_->set_singular_threshold(weak);
  }
  int rank() const { return by_pattern_ ? sparse_->rank() : dense_ ? dense_->rank() : 0; }
  double pivot_ratio() const { return by_pattern_ ? sparse_->pivot_ratio() : dense_ ? dense_->pivot_ratio() : 1; }
  // Changes when the multipliers do.
  long solutions() const { return solutions_; }
  void solve_constrained(double* w, const double* gamma, const double* extrapolated) const {
    ++solutions_;
    by_pattern_ ? sparse_->solve_constrained(w, gamma, extrapolated)
                : dense_->solve_constrained(w, gamma, extrapolated);
  }
  // For each column of w and gamma, see RowFactor.
  void solve_constrained(double* w, const double* gamma, int columns, bool regularized) const {
    ++solutions_;
    by_pattern_ ? sparse_->solve_constrained(w, gamma, columns, regularized)
                : dense_->solve_constrained(w, gamma, columns, regularized);
  }
  void multipliers(double* lambda) const { by_pattern_ ? sparse_->multipliers(lambda) : dense_->multipliers(lambda); }
  void min_norm(const double* residual, double* w) const {
    ++solutions_;
    by_pattern_ ? sparse_->min_norm(residual, w) : dense_->min_norm(residual, w);
  }

 private:
  // Fewer constraint equations are factorized densely. For this number, the sparse method costs a quarter more if there
  // are no zeros, which hardly ever happens in mechanisms; if half of the entries are zero, it costs a tenth less.
  static constexpr int min_sparse_rows = 8;
  // Numbers; larger dense factors are allocated only when they are needed.
  static constexpr double max_preallocated_size = 1e6;

  bool factorize_sparsely() {
    sparse_->begin();
    return std::ranges::all_of(sparse_->blocks(), [this](const SparseRowFactor::Block& block) {
      for (int i = 0; i < static_cast<int>(block.size()); ++i) {
        J_.scatter(block[i], sparse_->work(i));
        M_.solve_transposed(sparse_->work(i), pattern_[block[i]]);
      }
      return sparse_->append(block);
    });
  }

  const MassFactor<A>& M_;
  const SparseRows& J_;
  int n_, m_;
  std::vector<std::vector<int>> pattern_;  // by constraint equation: the nonzeros of its whitened column, ascending
  std::optional<RowFactor> dense_;
  std::optional<SparseRowFactor> sparse_;
  mutable long solutions_ = 0;
  bool by_pattern_ = false;  // the last factorize() was sparse
  double singular_threshold_ = 0;
};

}  // namespace gelenk
