// SPDX-License-Identifier: BSD-3-Clause
#include "assembly/row_space.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "decomposition/dense.h"

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Number of columns up to which dense factors with sorted pivots, which reveal the rank best, cost little.
constexpr Index max_dense_columns = 300;
constexpr Index max_basis_columns = 64;   // beyond this a basis of sparse equations is too expensive
constexpr double min_pivot_ratio = 1e-9;  // relative to the largest pivot, in a basis
constexpr double second_weight = 1e-4;    // root of the weight of what is minimized second
constexpr double regularization = 1e-12;  // relative to the largest entry, where no basis is used
constexpr Index max_short_row = 16;       // entries of a row whose products with itself are added to a sparse matrix

bool is_large(const SparseMatrix& G) { return G.cols() > max_dense_columns; }

// The equations of A^T A x = b, in which each long row a of A has an unknown w = a x of its own: its products with
// itself, as many as there are pairs of bodies in a loop, are not formed.
class NormalEquations {
 public:
  explicit NormalEquations(Index columns) : unknowns_(columns), diagonal_(VectorXd::Zero(columns)) {}

  void add(const SparseMatrix& A) {
    const Eigen::SparseMatrix<double, Eigen::RowMajor> rows = A;
    for (Index r = 0; r < rows.rows(); ++r) {
      const Index count = rows.outerIndexPtr()[r + 1] - rows.outerIndexPtr()[r];
      using Entry = Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator;
      for (Entry at(rows, r); at; ++at) diagonal_[at.col()] += at.value() * at.value();
      if (count > max_short_row) {
        for (Entry at(rows, r); at; ++at) add(unknowns_, at.col(), at.value());
        entries_.emplace_back(unknowns_, unknowns_, -1);
        ++unknowns_;
        continue;
      }
      for (Entry a(rows, r); a; ++a) {
        for (Entry b(rows, r); b; ++b) entries_.emplace_back(a.col(), b.col(), a.value() * b.value());
      }
    }
  }
  void add_to_diagonal(double x) {
    for (Index k = 0; k < diagonal_.size(); ++k) entries_.emplace_back(k, k, x);
  }
  // The largest diagonal entry of A^T A, without what was added to it.
  double size() const { return diagonal_.size() == 0 ? 0 : diagonal_.maxCoeff(); }
  // Rows to which the solution is subject, G x = 0, with this on the diagonal.
  void constrain(const SparseMatrix& G, double diagonal) {
    for (Index k = 0; k < G.cols(); ++k) {
      for (SparseMatrix::InnerIterator at(G, k); at; ++at) add(unknowns_ + at.row(), k, at.value());
    }
    for (Index r = 0; r < G.rows(); ++r) entries_.emplace_back(unknowns_ + r, unknowns_ + r, diagonal);
    unknowns_ += G.rows();
  }
  VectorXd solve(const VectorXd& b) const {
    SparseMatrix K(unknowns_, unknowns_);
    K.setFromTriplets(entries_.begin(), entries_.end());
    const Eigen::SimplicialLDLT<SparseMatrix> factor(K);
    VectorXd right = VectorXd::Zero(unknowns_);
    right.head(b.size()) = b;
    return factor.solve(right).head(b.size());
  }

 private:
  void add(Index row, Index column, double x) {
    entries_.emplace_back(row, column, x);
    entries_.emplace_back(column, row, x);
  }

  Index unknowns_;
  VectorXd diagonal_;
  std::vector<Eigen::Triplet<double>> entries_;
};

}  // namespace

RowSpace::RowSpace(const SparseMatrix& G, double threshold) : G_(G), threshold_(threshold) {
  if (!is_large(G_) || G_.rows() == 0) return;
  G_.makeCompressed();
  SparseMatrix columns = G_.transpose();
  columns.makeCompressed();
  sparse_ = std::make_unique<Factor>();
  double largest = 0;
  for (Index k = 0; k < columns.cols(); ++k) largest = std::max(largest, columns.col(k).norm());
  sparse_->setPivotThreshold((threshold_ > 0 ? threshold_ : min_pivot_ratio) * largest);
  sparse_->compute(columns);
  if (sparse_->info() != Eigen::Success)
    throw std::runtime_error("sparse QR factorization of the constraint Jacobian failed");
}

Index RowSpace::rank() const {
  if (sparse_) return sparse_->rank();
  return G_.cols() - basis().cols();
}

bool RowSpace::has_basis() const { return !is_large(G_) || degrees_of_freedom() <= max_basis_columns; }

VectorXd RowSpace::min_norm(const VectorXd& b) const {
  if (G_.rows() == 0 || G_.cols() == 0) return VectorXd::Zero(G_.cols());
  if (!sparse_) return least_norm_solution(G_, b, threshold_);
  // G^T P = Q R, so that R_1^T (Q^T x) = P^T b.
  const Index r = sparse_->rank();
  const VectorXd sorted = sparse_->colsPermutation().transpose() * b;
  const SparseMatrix R = sparse_->matrixR().topLeftCorner(r, r);
  VectorXd y = VectorXd::Zero(G_.cols());
  y.head(r) = R.transpose().triangularView<Eigen::Lower>().solve(sorted.head(r));
  return sparse_->matrixQ() * y;
}

VectorXd RowSpace::multipliers(const VectorXd& b) const {
  if (G_.rows() == 0) return {};
  if (!sparse_) return least_norm_solution(G_.transpose(), b);
  return sparse_->solve(b);
}

VectorXd RowSpace::null_space_part(const VectorXd& x) const {
  if (G_.rows() == 0) return x;
  if (!sparse_) return basis() * (basis().transpose() * x);
  VectorXd y = sparse_->matrixQ().transpose() * x;
  y.head(sparse_->rank()).setZero();
  return sparse_->matrixQ() * y;
}

const MatrixXd& RowSpace::basis() const {
  if (!basis_) {
    basis_ = sparse_ ? sparse_basis() : null_space(G_, threshold_ > 0 ? threshold_ : min_pivot_ratio);
  }
  return *basis_;
}

MatrixXd RowSpace::sparse_basis() const {
  const Index r = sparse_->rank();
  MatrixXd out = MatrixXd::Zero(G_.cols(), degrees_of_freedom());
  for (Index k = 0; k < out.cols(); ++k) {
    const VectorXd e = VectorXd::Unit(G_.cols(), r + k);
    const VectorXd column = sparse_->matrixQ() * e;
    out.col(k) = column;
  }
  return out;
}

VectorXd nearest(const RowSpace& rows, const SparseMatrix& T, const VectorXd& d) {
  if (rows.has_basis()) {
    const MatrixXd& Z = rows.basis();
    if (Z.cols() == 0) return VectorXd::Zero(T.cols());
    return -(Z * least_norm_solution(T * Z, d));
  }
  // [T^T T, G^T; G, 0] with a small regularization of the diagonal, so that it can be factorized in any order.
  const SparseMatrix& G = rows.rows();
  constexpr double tiny = 1e-300;  // if all entries are 0
  NormalEquations equations(G.cols());
  equations.add(T);
  const double size = std::max(tiny, equations.size());
  const double row_size = G.nonZeros() > 0 ? std::max(tiny, G.coeffs().square().maxCoeff()) : tiny;
  equations.add_to_diagonal(regularization * 1e3 * size);
  equations.constrain(G, -regularization * row_size / size);
  return rows.null_space_part(equations.solve(-(T.transpose() * d)));  // removes the error of the regularization
}

VectorXd nearest(const RowSpace& rows, const SparseMatrix& T, const VectorXd& d, const std::vector<bool>& first) {
  VectorXd weights(d.size());  // of the first components
  for (Index r = 0; r < d.size(); ++r) weights[r] = first[static_cast<std::size_t>(r)] ? 1 : 0;
  if (!rows.has_basis()) {
    const VectorXd both = weights.unaryExpr([](double x) { return x > 0 ? x : second_weight; });
    return nearest(rows, both.asDiagonal() * T, both.cwiseProduct(d));
  }
  const MatrixXd& Z = rows.basis();
  if (Z.cols() == 0) return VectorXd::Zero(T.cols());
  const MatrixXd along = T * Z;
  MatrixXd along_first = weights.asDiagonal() * along;
  // What the rows hold moves only by rounding, of which no step may be made.
  const VectorXd sizes = SparseMatrix(T.cwiseProduct(T)) * VectorXd::Ones(T.cols());
  for (Index r = 0; r < along.rows(); ++r) {
    if (along.row(r).norm() <= min_pivot_ratio * std::sqrt(sizes[r])) along_first.row(r).setZero();
  }
  VectorXd x = -least_norm_solution(along_first, weights.cwiseProduct(d), min_pivot_ratio);
  const MatrixXd N = null_space(along_first, min_pivot_ratio);
  if (N.cols() > 0) x -= N * least_norm_solution(along * N, d + along * x);
  return Z * x;
}

SparseMatrix plus_diagonal(const SparseMatrix& A, double x) {
  SparseMatrix I(A.rows(), A.cols());
  I.setIdentity();
  return A + x * I;
}

VectorXd solve_definite(const SparseMatrix& A, const VectorXd& b) {
  if (!is_large(A)) return symmetric_solution(A, b);
  const Eigen::SimplicialLDLT<SparseMatrix> factor(A);
  return factor.solve(b);
}

VectorXd solve_normal(const SparseMatrix& A, const SparseMatrix& B, double shift, const VectorXd& b) {
  if (!is_large(A)) {
    const SparseMatrix normal = A.transpose() * A + SparseMatrix(B.transpose() * B);
    return symmetric_solution(plus_diagonal(normal, shift), b);
  }
  NormalEquations equations(A.cols());
  equations.add(A);
  equations.add(B);
  equations.add_to_diagonal(shift);
  return equations.solve(b);
}

}  // namespace gelenk
