// SPDX-License-Identifier: BSD-3-Clause
// Rank-revealing QR factorization of the whitened constraint Jacobian Y = L^-T J^T (n velocities by m constraint
// equations), M = L^T L.
//
// With w = L vdot the equations M vdot + J^T lambda = tau, J vdot = gamma become
//   w + Y lambda = a,   Y^T w = gamma,   a = L^-T tau,
// so w is the projection of a onto the constraints in the mass metric (Udwadia & Kalaba 1992). Y P = Q R by
// Householder's method with column pivoting (Golub & Van Loan, sec. 5.4.2), truncated at rank r. If r < m, a second
// factorization, R_1^T = Z T, gives the least-squares w and the minimum-norm lambda (complete orthogonal
// decomposition, ibid. sec. 5.4.7). The condition number of Y is never squared.
#pragma once

#include <vector>

#include "linear/weak_pivots.h"

namespace gelenk {

class RowFactor {
 public:
  // Pivots below this fraction of the largest are rounding: the constraint Jacobian is computed from products of some
  // tens of poses, each exact to 1e-16, at positions with closure errors of about 1e-14.
  static constexpr double rank_threshold = 1e-12;

  // rows: at most.
  RowFactor(int nv, int rows);

  // The number of constraint equations that follow; initially all.
  void set_rows(int rows) { m_ = rows; }
  // Column r of Y (constraint equation r), n numbers, to be filled in before factorize().
  double* column(int r) { return Y_.data() + static_cast<std::size_t>(r) * n_; }

  // Pivots p (relative to the largest) near or below this threshold are weak: along their directions the constraint
  // equations count with the weight p^2 / (p^2 + threshold^2) in min_norm() and, if an extrapolated solution is given
  // for the rest, with p^6 / (p^6 + threshold^6) in solve_constrained(). 0: no pivot is weak.
  void set_singular_threshold(double threshold) { singular_threshold_ = threshold; }

  // Uses at most max_rank pivots. The other equations are redundant, even if they do not appear so at a position that
  // violates the constraints.
  void factorize(int max_rank);
  int rank() const { return rank_; }
  // The number of pivots of at least this size.
  int pivots_above(double least) const;
  // Ratio of the smallest pivot used to the largest, a measure of the distance to rank loss; 1 without constraints.
  double pivot_ratio() const { return pivot_ratio_; }

  // w <- the vector nearest to a (passed in w) with Y^T w = gamma. extrapolated: n numbers that replace the constraint
  // equations in the directions of weak pivots, or null: no pivot is treated as weak.
  void solve_constrained(double* w, const double* gamma, const double* extrapolated) const;
  // The same for each column of w (n x columns) and gamma (m x columns), stored row by row. regularized: with 0 as the
  // extrapolated solution; otherwise no pivot is weak. multipliers() is not available afterwards.
  void solve_constrained(double* w, const double* gamma, int columns, bool regularized) const;
  // The multipliers of the last solve_constrained(), of minimum norm.
  void multipliers(double* lambda) const;
  // w <- the minimum-norm solution of Y^T w = residual.
  void min_norm(const double* residual, double* w) const;

 private:
  void factorize_constraints(int max_rank);
  void reflect_column(int k, int j);
  void factorize_redundant();
  double relative_pivot(int k) const { return diagonal_[k] / diagonal_[0]; }
  void reflect(double* x) const;                     // x <- Q^T x
  void unreflect(double* x) const;                   // x <- Q x
  void solve_Rt(const double* in, double* d) const;  // d = least-squares solution of R_1^T d = P^T in
  void solve_Rt(const double* in, int columns, double* d, double* sum) const;
  void solve_R(const double* d, double* lambda) const;  // lambda = minimum-norm solution of R_1 P^T lambda = d

  int n_, m_;  // m_: present equations
  int rank_ = 0;
  double pivot_ratio_ = 1;
  double singular_threshold_ = 0;
  std::vector<double> Y_;                         // R above, Householder vectors from the diagonal down
  std::vector<double> diagonal_;                  // of R
  std::vector<double> scale_;                     // 2 / |u|^2 of each Householder vector
  std::vector<int> order_;                        // column k of R belongs to row order_[k]
  std::vector<double> norms_;                     // squared norms of the remainder of each column
  std::vector<int> ends_;                         // of the nonzeros of each column
  std::vector<double> Z_, T_diagonal_, Z_scale_;  // of R_1^T, m x rank, column-major
  mutable std::vector<double> d_, e_, f_;
  mutable std::vector<double> columns_;
};

}  // namespace gelenk
