// SPDX-License-Identifier: BSD-3-Clause
// Linear algebra of assembly on constraint equations: dense factors with pivots sorted by size, or sparse ones where
// the matrix is large and sparse, as for a long chain of loops.
#pragma once

#include <Eigen/Core>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <Eigen/SparseQR>
#include <memory>
#include <optional>
#include <vector>

namespace gelenk {

using SparseMatrix = Eigen::SparseMatrix<double>;

// Factors of G (rows x n) of any rank. threshold: pivot size relative to the largest, below which a pivot is zero; 0:
// rounding. Throws std::runtime_error if the sparse factorization fails.
class RowSpace {
 public:
  explicit RowSpace(const SparseMatrix& G, double threshold = 0);

  // The minimum-norm least-squares solution of G x = b.
  Eigen::VectorXd min_norm(const Eigen::VectorXd& b) const;
  // The least-squares solution of G^T l = b.
  Eigen::VectorXd multipliers(const Eigen::VectorXd& b) const;
  // The orthogonal projection of x onto the null space of G.
  Eigen::VectorXd null_space_part(const Eigen::VectorXd& x) const;
  // An orthonormal basis of the null space of G, n x degrees_of_freedom().
  const Eigen::MatrixXd& basis() const;
  Eigen::Index degrees_of_freedom() const { return G_.cols() - rank(); }
  Eigen::Index rank() const;
  // Whether the basis is small enough to be used.
  bool has_basis() const;
  const SparseMatrix& rows() const { return G_; }

 private:
  using Factor = Eigen::SparseQR<SparseMatrix, Eigen::COLAMDOrdering<int>>;  // of G^T
  Eigen::MatrixXd sparse_basis() const;

  SparseMatrix G_;
  double threshold_;
  std::unique_ptr<Factor> sparse_;
  mutable std::optional<Eigen::MatrixXd> basis_;  // computed on first use
};

// The x in the null space of G that minimizes |T x + d|.
Eigen::VectorXd nearest(const RowSpace& rows, const SparseMatrix& T, const Eigen::VectorXd& d);
// The same, where first the components of T x + d in `first` are minimized and then, as far as x is not determined, the
// others; without a basis of the null space the latter are weighted so weakly that they hardly move the former.
Eigen::VectorXd nearest(const RowSpace& rows, const SparseMatrix& T, const Eigen::VectorXd& d,
                        const std::vector<bool>& first);

// A + x I.
SparseMatrix plus_diagonal(const SparseMatrix& A, double x);

// Solves A x = b for a symmetric positive definite A.
Eigen::VectorXd solve_definite(const SparseMatrix& A, const Eigen::VectorXd& b);

// Solves (A^T A + B^T B + shift I) x = b.
Eigen::VectorXd solve_normal(const SparseMatrix& A, const SparseMatrix& B, double shift, const Eigen::VectorXd& b);

}  // namespace gelenk
