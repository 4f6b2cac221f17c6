// SPDX-License-Identifier: BSD-3-Clause
// A cone problem that outlives the step that it is from, for charts and tests of the solvers.
#pragma once

#include <vector>

#include "complementarity/cone.h"

namespace gelenk {

class RecordedProblem final : public ConeOperator {
 public:
  // Copies the matrix, the root, or both, whichever there is; else forms the matrix.
  explicit RecordedProblem(const ConeProblem& of);
  RecordedProblem(const Eigen::MatrixXd& G, const Eigen::VectorXd& b, std::vector<Cone> cones);

  // Valid as long as this is.
  ConeProblem problem(bool exact_coulomb) const { return {*this, b_, cones_, exact_coulomb}; }
  std::span<const double> b() const { return b_; }
  std::span<const Cone> cones() const { return cones_; }
  Eigen::MatrixXd matrix() const;  // also where methods have only the root
  // The same for methods as if there were too many rows for a matrix, if there is a root.
  RecordedProblem without_matrix() const;

  int size() const override { return static_cast<int>(b_.size()); }
  void apply(const double* x, double* y) const override;
  void diagonal_block(const Cone& cone, double* out) const override;
  const double* dense() const override { return G_.size() > 0 ? G_.data() : nullptr; }
  ConeRoot root() const override { return {root_rows_, first_, row_, value_}; }

 private:
  bool has_matrix() const { return G_.size() > 0 || b_.empty(); }
  // Entries of column j of the root.
  int begin(int j) const { return first_[static_cast<std::size_t>(j)]; }
  int end(int j) const { return first_[static_cast<std::size_t>(j) + 1]; }
  double product_of_columns(int i, int j) const;

  Eigen::MatrixXd G_;
  int root_rows_ = 0;
  std::vector<int> first_, row_;
  std::vector<double> value_;
  std::vector<double> b_;
  std::vector<Cone> cones_;
};

}  // namespace gelenk
