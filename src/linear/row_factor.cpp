// SPDX-License-Identifier: BSD-3-Clause
#include "linear/row_factor.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gelenk {
namespace {

// In four parts, which do not wait for each other.
double long_dot(const double* a, const double* b, int n) {
  double parts[4] = {};
  int i = 0;
  for (; i + 4 <= n; i += 4) {
    for (int k = 0; k < 4; ++k) parts[k] += a[i + k] * b[i + k];
  }
  double sum = (parts[0] + parts[1]) + (parts[2] + parts[3]);
  for (; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

inline double dot(const double* a, const double* b, int n) {
  if (n >= 16) return long_dot(a, b, n);
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

void add(double factor, const double* __restrict a, double* __restrict b, int n) {
  for (int i = 0; i < n; ++i) b[i] += factor * a[i];
}

// Turns x, with the given norm, into a Householder vector in place; returns the new first entry of the reflected x
// and 2 / |u|^2 in scale.
double householder(double* x, double norm, double& scale) {
  if (norm == 0) {
    scale = 0;
    return 0;
  }
  const double alpha = x[0] > 0 ? -norm : norm;  // the sign that does not cancel
  const double first = x[0];
  x[0] -= alpha;
  scale = 1 / (norm * (norm + std::abs(first)));
  return alpha;
}

}  // namespace

RowFactor::RowFactor(int nv, int rows)
    : n_(nv),
      m_(rows),
      Y_(static_cast<std::size_t>(nv) * rows),
      diagonal_(rows),
      scale_(rows),
      order_(rows),
      norms_(rows),
      ends_(rows),
      Z_(static_cast<std::size_t>(rows) * rows),
      T_diagonal_(rows),
      Z_scale_(rows),
      d_(std::max(nv, rows)),
      e_(std::max(nv, rows)),
      f_(std::max(nv, rows)) {}

void RowFactor::factorize(int max_rank) {
  factorize_constraints(std::min({max_rank, n_, m_}));
  if (rank_ < m_) factorize_redundant();
}

// Columns have zeros below their ends, as those of locked coordinates beyond their own joint in a tree.
void RowFactor::factorize_constraints(int max_rank) {
  std::iota(order_.begin(), order_.begin() + m_, 0);
  rank_ = 0;
  pivot_ratio_ = 1;
  for (int j = 0; j < m_; ++j) {
    ends_[j] = n_;
    while (ends_[j] > 0 && column(j)[ends_[j] - 1] == 0) --ends_[j];
    norms_[j] = dot(column(j), column(j), ends_[j]);
  }
  for (int k = 0; k < max_rank; ++k) {
    int best = k;
    for (int j = k + 1; j < m_; ++j) {
      if (norms_[j] > norms_[best]) best = j;
    }
    if (best != k) {
      std::swap_ranges(column(k), column(k) + std::max(ends_[k], ends_[best]), column(best));
      std::swap(order_[k], order_[best]);
      std::swap(ends_[k], ends_[best]);
      std::swap(norms_[k], norms_[best]);
    }
    const double pivot = std::sqrt(norms_[k]);
    const double first = k == 0 ? pivot : std::abs(diagonal_[0]);
    if (!(pivot > rank_threshold * first)) break;
    pivot_ratio_ = pivot / first;
    double* u = column(k) + k;
    diagonal_[k] = householder(u, pivot, scale_[k]);
    for (int j = k + 1; j < m_; ++j) reflect_column(k, j);
    rank_ = k + 1;
  }
}

int RowFactor::pivots_above(double least) const {
  const auto end = diagonal_.begin() + rank_;
  return static_cast<int>(
      std::count_if(diagonal_.begin(), end, [&](double pivot) { return std::abs(pivot) >= least; }));
}

void RowFactor::reflect_column(int k, int j) {
  const double* u = column(k) + k;
  double* y = column(j) + k;
  const double along = dot(u, y, std::min(ends_[k], ends_[j]) - k);
  if (along == 0 && y[0] == 0) return;
  if (along != 0) {
    add(-scale_[k] * along, u, y, ends_[k] - k);
    ends_[j] = std::max(ends_[j], ends_[k]);
  }
  // Recomputed, since downdating loses exactly the small norms that decide the rank.
  norms_[j] = dot(y + 1, y + 1, ends_[j] - k - 1);
}

void RowFactor::factorize_redundant() {
  // Column i of R_1^T is row i of R_1.
  for (int i = 0; i < rank_; ++i) {
    double* z = &Z_[static_cast<std::size_t>(i) * m_];
    for (int j = 0; j < m_; ++j) z[j] = j < i ? 0 : (j == i ? diagonal_[i] : column(j)[i]);
  }
  for (int k = 0; k < rank_; ++k) {
    double* u = &Z_[static_cast<std::size_t>(k) * m_] + k;
    T_diagonal_[k] = householder(u, std::sqrt(dot(u, u, m_ - k)), Z_scale_[k]);
    for (int j = k + 1; j < rank_; ++j) {
      double* z = &Z_[static_cast<std::size_t>(j) * m_] + k;
      add(-Z_scale_[k] * dot(u, z, m_ - k), u, z, m_ - k);
    }
  }
}

void RowFactor::reflect(double* x) const {
  for (int k = 0; k < rank_; ++k) {
    const double* u = &Y_[static_cast<std::size_t>(k) * n_] + k;
    add(-scale_[k] * dot(u, x + k, n_ - k), u, x + k, n_ - k);
  }
}

void RowFactor::unreflect(double* x) const {
  for (int k = rank_ - 1; k >= 0; --k) {
    const double* u = &Y_[static_cast<std::size_t>(k) * n_] + k;
    add(-scale_[k] * dot(u, x + k, n_ - k), u, x + k, n_ - k);
  }
}

void RowFactor::solve_Rt(const double* in, double* d) const {
  if (rank_ == m_) {
    for (int k = 0; k < rank_; ++k) {
      const double* r = &Y_[static_cast<std::size_t>(k) * n_];
      d[k] = (in[order_[k]] - dot(r, d, k)) / diagonal_[k];
    }
    return;
  }
  double* e = e_.data();
  for (int k = 0; k < m_; ++k) e[k] = in[order_[k]];
  for (int k = 0; k < rank_; ++k) {
    const double* u = &Z_[static_cast<std::size_t>(k) * m_] + k;
    add(-Z_scale_[k] * dot(u, e + k, m_ - k), u, e + k, m_ - k);
  }
  for (int k = rank_ - 1; k >= 0; --k) {
    double sum = e[k];
    for (int j = k + 1; j < rank_; ++j) sum -= Z_[static_cast<std::size_t>(j) * m_ + k] * d[j];
    d[k] = sum / T_diagonal_[k];
  }
}

void RowFactor::solve_R(const double* d, double* lambda) const {
  double* e = e_.data();
  if (rank_ == m_) {
    for (int k = rank_ - 1; k >= 0; --k) {
      double sum = d[k];
      for (int j = k + 1; j < rank_; ++j) sum -= Y_[static_cast<std::size_t>(j) * n_ + k] * e[j];
      e[k] = sum / diagonal_[k];
    }
  } else {
    for (int k = 0; k < rank_; ++k) {
      const double* t = &Z_[static_cast<std::size_t>(k) * m_];
      e[k] = (d[k] - dot(t, e, k)) / T_diagonal_[k];
    }
    std::fill(e + rank_, e + m_, 0.0);
    for (int k = rank_ - 1; k >= 0; --k) {
      const double* u = &Z_[static_cast<std::size_t>(k) * m_] + k;
      add(-Z_scale_[k] * dot(u, e + k, m_ - k), u, e + k, m_ - k);
    }
  }
  for (int k = 0; k < m_; ++k) lambda[order_[k]] = e[k];
}

void RowFactor::solve_constrained(double* w, const double* gamma, const double* extrapolated) const {
  double* d = d_.data();
  double* f = f_.data();
  solve_Rt(gamma, d);
  reflect(w);
  double* e = e_.data();
  if (extrapolated != nullptr) {
    std::copy(extrapolated, extrapolated + n_, e);
    reflect(e);
  }
  for (int k = 0; k < rank_; ++k) {
    const double s = extrapolated == nullptr ? 1 : equation_weight(relative_pivot(k), singular_threshold_);
    const double sum = extrapolated == nullptr ? d[k] : s * d[k] + (1 - s) * e[k];
    f[k] = w[k] - sum;  // what the constraints remove, in the basis Q
    w[k] = sum;
  }
  unreflect(w);
}

void RowFactor::multipliers(double* lambda) const { solve_R(f_.data(), lambda); }

void RowFactor::min_norm(const double* residual, double* w) const {
  double* d = d_.data();
  solve_Rt(residual, d);
  for (int k = 0; k < rank_; ++k) w[k] = damping_weight(relative_pivot(k), singular_threshold_) * d[k];
  std::fill(w + rank_, w + n_, 0.0);
  unreflect(w);
}

}  // namespace gelenk
