// SPDX-License-Identifier: BSD-3-Clause
#include "recorded/elimination.h"

#include <utility>

namespace gelenk {
namespace {

using recording::Recorded;

Recorded entry(const EquationTerms& of, const Terms& matrix, int row, int column) {
  return Recorded::of(matrix[static_cast<std::size_t>(row) * of.nv + static_cast<std::size_t>(column)]);
}

}  // namespace

Elimination::Elimination(const EquationTerms& equations, const Pivots& pivots)
    : pivots_(pivots), nv_(static_cast<int>(equations.nv)) {
  std::vector<bool> is_dependent(static_cast<std::size_t>(nv_), false);
  for (const int column : pivots_.columns) is_dependent[static_cast<std::size_t>(column)] = true;
  for (int k = 0; k < nv_; ++k) {
    if (!is_dependent[static_cast<std::size_t>(k)]) free_.push_back(k);
  }
  factorize_constraints(equations);
  factorize_mass(equations);
}

void Elimination::factorize_constraints(const EquationTerms& equations) {
  const std::size_t n = pivots_.rows.size();
  for (std::size_t i = 0; i < n; ++i) {
    Numbers& row = LU_.emplace_back();
    for (const int column : pivots_.columns) row.push_back(entry(equations, equations.J, pivots_.rows[i], column));
  }
  for (std::size_t k = 0; k < n; ++k) {
    reciprocal_.push_back(Recorded(1) / LU_[k][k]);
    for (std::size_t i = k + 1; i < n; ++i) {
      LU_[i][k] *= reciprocal_[k];
      for (std::size_t j = k + 1; j < n; ++j) LU_[i][j] -= LU_[i][k] * LU_[k][j];
    }
  }
  T_.assign(n, Numbers(free_.size()));
  for (std::size_t f = 0; f < free_.size(); ++f) {
    Numbers right_side;
    for (const int row : pivots_.rows) right_side.push_back(-entry(equations, equations.J, row, free_[f]));
    const Numbers column = dependent(right_side);
    for (std::size_t i = 0; i < n; ++i) T_[i][f] = column[i];
  }
}

// From the last velocity to the first: those of branches of a tree then remain apart.
void Elimination::factorize_mass(const EquationTerms& equations) {
  const std::size_t n = pivots_.columns.size();
  const std::size_t f = free_.size();
  const auto M = [&](int row, int column) { return entry(equations, equations.M, row, column); };
  TM_d_.assign(f, Numbers(n));
  L_.assign(f, Numbers(f));
  for (std::size_t i = 0; i < f; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      TM_d_[i][j] = M(free_[i], pivots_.columns[j]);
      for (std::size_t k = 0; k < n; ++k) TM_d_[i][j] += T_[k][i] * M(pivots_.columns[k], pivots_.columns[j]);
    }
  }
  for (std::size_t i = 0; i < f; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      Recorded& entry = L_[i][j];
      entry = M(free_[i], free_[j]);
      for (std::size_t k = 0; k < n; ++k) entry += T_[k][i] * M(pivots_.columns[k], free_[j]) + TM_d_[i][k] * T_[k][j];
    }
  }
  reciprocal_mass_.resize(f);
  for (std::size_t k = f; k-- > 0;) {
    reciprocal_mass_[k] = Recorded(1) / L_[k][k];
    for (std::size_t i = k; i-- > 0;) {
      const Recorded factor = L_[k][i] * reciprocal_mass_[k];
      for (std::size_t j = 0; j <= i; ++j) L_[i][j] -= factor * L_[k][j];
      L_[k][i] = factor;
    }
  }
}

Elimination::Numbers Elimination::dependent(Numbers right_side) const {
  Numbers& x = right_side;
  const std::size_t n = x.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < i; ++k) x[i] -= LU_[i][k] * x[k];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) x[i] -= LU_[i][k] * x[k];
    x[i] *= reciprocal_[i];
  }
  return right_side;
}

Elimination::Numbers Elimination::independent(Numbers right_side) const {
  Numbers& x = right_side;
  const std::size_t n = x.size();
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t i = 0; i < k; ++i) x[i] -= L_[k][i] * x[k];
  }
  for (std::size_t k = 0; k < n; ++k) {
    x[k] *= reciprocal_mass_[k];
    for (std::size_t i = 0; i < k; ++i) x[k] -= L_[k][i] * x[i];
  }
  return right_side;
}

Elimination::Numbers Elimination::whole(const Numbers& particular, const Numbers& free) const {
  Numbers out(static_cast<std::size_t>(nv_));
  for (std::size_t i = 0; i < free.size(); ++i) out[static_cast<std::size_t>(free_[i])] = free[i];
  for (std::size_t i = 0; i < particular.size(); ++i) {
    Recorded& x = out[static_cast<std::size_t>(pivots_.columns[i])];
    x = particular[i];
    for (std::size_t k = 0; k < free.size(); ++k) x += T_[i][k] * free[k];
  }
  return out;
}

// 0 = T^T (M vdot + h), vdot = (x_d; 0) + T a with J_d x_d = gamma.
Elimination::Numbers Elimination::accelerations(const Numbers& gamma, const Numbers& h) const {
  const Numbers particular = dependent(gamma);
  Numbers forces;
  for (std::size_t i = 0; i < free_.size(); ++i) {
    Recorded force = -h[static_cast<std::size_t>(free_[i])];
    for (std::size_t k = 0; k < particular.size(); ++k) {
      force -= T_[k][i] * h[static_cast<std::size_t>(pivots_.columns[k])];
      force -= TM_d_[i][k] * particular[k];
    }
    forces.push_back(force);
  }
  return whole(particular, independent(forces));
}

Elimination::Numbers Elimination::displacement(const Numbers& residual) const {
  Numbers negative;
  for (const Recorded& x : residual) negative.push_back(-x);
  const Numbers particular = dependent(negative);
  Numbers right_side;
  for (std::size_t i = 0; i < free_.size(); ++i) {
    Recorded sum(0);
    for (std::size_t k = 0; k < particular.size(); ++k) sum -= TM_d_[i][k] * particular[k];
    right_side.push_back(sum);
  }
  return whole(particular, independent(right_side));
}

}  // namespace gelenk
