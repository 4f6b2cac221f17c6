// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "complementarity/cone.h"
#include "dynamics/contact_rows.h"

namespace gelenk {

// The Delassus operator of rows, the velocities that impulses along them cause: a matrix if they are few.
class DelassusOperator final : public ConeOperator {
 public:
  explicit DelassusOperator(const ContactRows& rows) : rows_(rows) {}

  void reserve(std::size_t rows) {
    numbers_.reserve(rows * rows);
    unit_.reserve(rows);
  }

  // Call when the rows have changed.
  void update() {
    const int n = rows_.count();
    is_dense_ = n <= (root().first.empty() ? max_dense_rows : most_with_matrix_and_root);
    if (!is_dense_) return;
    numbers_.resize(static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
    unit_.assign(static_cast<std::size_t>(n), 0.0);
    for (int j = 0; j < n; ++j) {
      unit_[static_cast<std::size_t>(j)] = 1;
      rows_.apply(unit_.data(), numbers_.data() + static_cast<std::ptrdiff_t>(n) * j);
      unit_[static_cast<std::size_t>(j)] = 0;
    }
    Eigen::Map<Eigen::MatrixXd> G(numbers_.data(), n, n);
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < j; ++i) G(i, j) = G(j, i) = (G(i, j) + G(j, i)) / 2;
    }
  }
  // Adds this part of it to the diagonal of the matrix, until update().
  void soften(double part) {
    Eigen::Map<Eigen::MatrixXd> G(numbers_.data(), size(), size());
    G.diagonal() *= 1 + part;
  }
  // Of impulses: the sum of the energies that each row alone would exchange.
  double size_of(const std::vector<double>& x) const {
    double sum = 0;
    for (int i = 0; i < size(); ++i)
      sum += matrix()(i, i) * x[static_cast<std::size_t>(i)] * x[static_cast<std::size_t>(i)];
    return sum;
  }
  int size() const override { return rows_.count(); }
  void apply(const double* x, double* y) const override {
    if (!is_dense_) return rows_.apply(x, y);
    const int n = size();
    Eigen::Map<Eigen::VectorXd>(y, n).noalias() = matrix() * Eigen::Map<const Eigen::VectorXd>(x, n);
  }
  void diagonal_block(const Cone& cone, double* out) const override {
    const int n = cone.size();
    if (!is_dense_) return rows_.block(cone.first, n, out);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) out[i * n + j] = matrix()(cone.first + i, cone.first + j);
    }
  }
  const double* dense() const override { return is_dense_ ? numbers_.data() : nullptr; }
  ConeRoot root() const override {
    const WhitenedRows rows = rows_.whitened();
    return {rows.columns, rows.first, rows.column, rows.value};
  }

 private:
  // Rows up to which it is a matrix if there is no root, as bodies with loops have none: larger ones cost more than
  // they save.
  static constexpr int max_dense_rows = 400;

  Eigen::Map<const Eigen::MatrixXd> matrix() const { return {numbers_.data(), size(), size()}; }

  const ContactRows& rows_;
  bool is_dense_ = false;
  std::vector<double> numbers_;  // of the matrix: they keep their memory when its size changes
  std::vector<double> unit_;
};

}  // namespace gelenk
