// SPDX-License-Identifier: BSD-3-Clause
// The parts of a cone problem that do not act on each other, as of boxes that lie apart on the ground: each is solved
// on its own. Many small problems cost far less than a large one, and one that converges slowly delays no other.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "complementarity/cone.h"
#include "complementarity/parts_of_problem.h"

namespace gelenk {

// Some unknowns of an operator, those of whole cones.
class PartOfOperator final : public ConeOperator {
 public:
  // unknowns: ascending. whole: has a matrix or a root.
  void restrict(const ConeOperator& whole, std::span<const int> unknowns);

  int size() const override { return size_; }
  void apply(const double* x, double* y) const override;
  void diagonal_block(const Cone& cone, double* out) const override;
  const double* dense() const override { return is_dense_ ? numbers_.data() : nullptr; }
  ConeRoot root() const override;

 private:
  void take_root(const ConeRoot& of, std::span<const int> unknowns);
  void multiply_root();
  double product(int i, int j) const;

  int size_ = 0;
  bool is_dense_ = false;
  std::vector<double> numbers_;  // of the matrix
  int rows_ = 0;                 // of the root
  std::vector<int> number_of_row_, first_, row_;
  std::vector<double> value_;
  mutable std::vector<double> image_;  // of the root
};

class IndependentParts final : public ConeSolver {
 public:
  explicit IndependentParts(std::unique_ptr<ConeSolver> of_parts) : of_parts_(std::move(of_parts)) {}

  // The result has the largest residual and number of iterations of all parts, and the sum of their products.
  ConeResult solve(const ConeProblem& problem, const ConeOptions& options, double* x) override;

 private:
  ConeResult solve_part(const ConeProblem& problem, const ConeOptions& options,
                        std::span<const std::pair<int, int>> cones);

  std::unique_ptr<ConeSolver> of_parts_;
  PartsOfProblem parts_;
  std::vector<int> unknowns_;  // of the present part
  std::vector<Cone> cones_;
  std::vector<double> b_, x_, found_;
  PartOfOperator operator_;
};

}  // namespace gelenk
