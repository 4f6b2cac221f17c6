// SPDX-License-Identifier: BSD-3-Clause
// Rank-revealing factorisation of the whitened rows Y = L^-T J^T (n speeds by m rows), M = L^T L.
//
// With w = L vdot the equations M vdot + J^T lambda = tau, J vdot = gamma become
//   w + Y lambda = a,   Y^T w = gamma,   a = L^-T tau,
// so w is a, moved by the least amount in the mass metric onto the rows (Udwadia & Kalaba 1992). Y P = Q R by
// Householder's method with column pivoting (Golub & Van Loan, sec. 5.4.2), cut off at rank r. Where r < m a second
// factorisation, R_1^T = Z T, gives the least-squares w and the minimum-norm lambda (complete orthogonal
// decomposition, ibid. sec. 5.4.7). The condition of Y is never squared.
#pragma once

#include <vector>

namespace gelenk {

class RowFactor {
 public:
  // Pivots below this fraction of the largest are rounding: rows here come from products of some tens of poses, each
  // exact to 1e-16, at positions closed to about 1e-14.
  static constexpr double rank_threshold = 1e-12;

  RowFactor(int speeds, int rows);

  // Column r of Y (whitened row r), to be filled before factorize().
  double* column(int r) { return Y_.data() + static_cast<std::size_t>(r) * n_; }

  // Pivots p near or below this fraction of the largest are weak: what the rows say along them is taken by the share
  // s = p^2 / (p^2 + weak^2), in constrain() where something else is expected there, and in shortest(). 0: none are.
  void set_weak(double weak) { weak_ = weak; }

  // At most max_rank pivots are used. The rest repeat others; off the constraints they may not look it.
  void factorize(int max_rank);
  int rank() const { return rank_; }
  // Smallest used pivot over the largest: what is left of the rank. 1 when there are no rows.
  double pivot_ratio() const { return ratio_; }

  // w <- the w nearest to a (given in w) with Y^T w = gamma. expected: n numbers that weak pivots' directions follow,
  // or null: no pivot is taken as weak.
  void solve_constrained(double* w, const double* gamma, const double* extrapolated) const;
  // The same for the columns of w (n x columns) and gamma (m x columns), stored row by row; follows: what is expected
  // along weak pivots is 0, else none is weak. Leaves nothing for multipliers().
  void solve_constrained(double* w, const double* gamma, int columns, bool regularized) const;
  // The multipliers of the last constrain(), minimum norm.
  void multipliers(double* lambda) const;
  // w <- the shortest w with Y^T w = residual.
  void min_norm(const double* residual, double* w) const;

 private:
  void factorize_constraints(int max_rank);
  void factorize_redundant();
  double damping_weight(int k) const;                // of pivot k, see set_weak
  void reflect(double* x) const;                     // x <- Q^T x
  void unreflect(double* x) const;                   // x <- Q x
  void solve_Rt(const double* in, double* d) const;  // d = least-squares solution of R_1^T d = P^T in
  void solve_Rt(const double* in, int columns, double* d, double* sum) const;
  void solve_R(const double* d, double* lambda) const;  // lambda = minimum-norm solution of R_1 P^T lambda = d

  int n_, m_;
  int rank_ = 0;
  double ratio_ = 1;
  double weak_ = 0;
  std::vector<double> Y_;                         // R above, Householder vectors from the diagonal down
  std::vector<double> diagonal_;                  // of R
  std::vector<double> scale_;                     // 2 / |u|^2 of each Householder vector
  std::vector<int> order_;                        // column k of R belongs to row order_[k]
  std::vector<double> norms_;                     // squared norms of what is left of each column
  std::vector<double> Z_, T_diagonal_, Z_scale_;  // of R_1^T, m x rank, column-major
  mutable std::vector<double> d_, e_, f_;
  mutable std::vector<double> columns_;
};

}  // namespace gelenk
