// SPDX-License-Identifier: BSD-3-Clause
// Linear algebra of assembly, on rows that must vanish: by dense factors with pivots sorted by size, or, where the rows
// are many and mostly zeros, as a long chain of loops has them, by sparse ones.
#pragma once

#include <Eigen/Core>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <Eigen/SparseQR>
#include <memory>
#include <optional>

namespace gelenk {

using SparseMatrix = Eigen::SparseMatrix<double>;

// Factors of G (rows x n), of any rank. threshold: of the largest pivot, below which one is zero; 0: rounding.
class RowSpace {
 public:
  explicit RowSpace(const SparseMatrix& G, double threshold = 0);

  // The shortest x with G x = b, as well as can be.
  Eigen::VectorXd min_norm(const Eigen::VectorXd& b) const;
  // l with G^T l = b, as well as can be.
  Eigen::VectorXd multipliers(const Eigen::VectorXd& b) const;
  // What of x the rows leave free.
  Eigen::VectorXd free_part(const Eigen::VectorXd& x) const;
  // An orthonormal basis of the x that the rows forbid nothing of, n x freedoms().
  const Eigen::MatrixXd& basis() const;
  Eigen::Index degrees_of_freedom() const { return G_.cols() - rank(); }
  Eigen::Index rank() const;
  // Whether a basis is small enough to be worked with.
  bool has_basis() const;
  const SparseMatrix& rows() const { return G_; }

 private:
  using Factor = Eigen::SparseQR<SparseMatrix, Eigen::COLAMDOrdering<int>>;  // of G^T
  Eigen::MatrixXd sparse_basis() const;

  SparseMatrix G_;
  double threshold_;
  std::unique_ptr<Factor> sparse_;
  mutable std::optional<Eigen::MatrixXd> basis_;  // once asked for
};

// x in the basis, or free of the rows, with the shortest T x + d.
Eigen::VectorXd nearest(const RowSpace& rows, const SparseMatrix& T, const Eigen::VectorXd& d);

// A + x I.
SparseMatrix plus_diagonal(const SparseMatrix& A, double x);

// A x = b for symmetric A that is positive definite.
Eigen::VectorXd solve_definite(const SparseMatrix& A, const Eigen::VectorXd& b);

// The basis of RowSpace, of rows that are not sparse. threshold: of the largest pivot, below which one is zero.
Eigen::MatrixXd nullspace(const Eigen::MatrixXd& G, Eigen::Index n, double threshold = 1e-9);

}  // namespace gelenk
