// SPDX-License-Identifier: BSD-3-Clause
// The linear equations of one step of assembly, in full or sparse.
#pragma once

#include <Eigen/Core>
#include <variant>

#include "assembly/row_space.h"

namespace gelenk {

// Number of unknowns up to which full matrices are used in closing loops: beyond, the sparse ones are cheaper.
inline constexpr Eigen::Index max_full_unknowns = 120;

// Minimum-norm steps x with G x = -r. damping: relative to the mean square of the rows' norms; it shortens the steps.
class ClosingStep {
 public:
  ClosingStep() = default;  // of no length: where a search gives up
  explicit ClosingStep(SparseMatrix rows);
  // The transpose of G, a column for each equation.
  explicit ClosingStep(Eigen::MatrixXd columns);
  Eigen::VectorXd operator()(const Eigen::VectorXd& r, double damping) const;

 private:
  std::variant<std::monostate, SparseMatrix, Eigen::MatrixXd> G_;  // by rows; by columns of the transpose
  double scale_ = 0;
};

// The x that minimizes |G x + r|^2 + |T x + d|^2 + damping |x|^2, with the transpose of G and diag(T^2).
Eigen::VectorXd relaxing_step(const Eigen::MatrixXd& columns, const Eigen::VectorXd& weights, const Eigen::VectorXd& r,
                              const Eigen::VectorXd& d, double damping);

}  // namespace gelenk
