// SPDX-License-Identifier: BSD-3-Clause
// Some rows and columns of an operator, as an operator for cones of one unknown each: what is left of a problem whose
// other unknowns are zero.
#pragma once

#include <vector>

#include "complementarity/cone.h"

namespace gelenk {

class SelectedRows final : public ConeOperator {
 public:
  void reserve(std::size_t rows);
  // all must outlive the use of this, with the same numbers. rows: ascending.
  void select(const ConeOperator& all, std::span<const int> rows);

  int size() const override { return static_cast<int>(rows_.size()); }
  void apply(const double* x, double* y) const override;
  void diagonal_block(const Cone& cone, double* out) const override;
  const double* dense() const override { return has_matrix_ ? matrix_.data() : nullptr; }
  ConeRoot root() const override { return {root_rows_, first_, row_, value_}; }

 private:
  void copy_matrix();
  void copy_root();

  const ConeOperator* all_ = nullptr;
  std::vector<int> rows_;
  bool has_matrix_ = false;
  std::vector<double> matrix_;
  int root_rows_ = 0;
  std::vector<int> first_, row_;
  std::vector<double> value_;
  mutable std::vector<double> in_, out_;  // of all rows
};

}  // namespace gelenk
