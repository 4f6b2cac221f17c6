// SPDX-License-Identifier: BSD-3-Clause
// The constraint Jacobian J by rows, without zeros: a loop depends on the velocities between its two ends and their
// nearest common ancestor only. The sparsity pattern is set up once.
#pragma once

#include <Eigen/SparseCore>
#include <algorithm>
#include <vector>

namespace gelenk {

class SparseRows {
 public:
  // Appends a row with nonzeros in these columns, in any order.
  void append(const std::vector<int>& columns) {
    columns_.insert(columns_.end(), columns.begin(), columns.end());
    values_.resize(columns_.size(), 0.0);
    first_.push_back(static_cast<int>(columns_.size()));
  }

  int rows() const { return static_cast<int>(first_.size()) - 1; }
  int entries(int row) const { return first_[row + 1] - first_[row]; }
  const int* columns(int row) const { return columns_.data() + first_[row]; }
  double* values(int row) { return values_.data() + first_[row]; }
  const double* values(int row) const { return values_.data() + first_[row]; }

  // Writes the row's entries to x (nv numbers); the other elements of x remain.
  void scatter(int row, double* x) const {
    const double* value = values(row);
    for (const int* k = columns(row); k != columns(row + 1); ++k) x[*k] = *value++;
  }
  // J as a sparse matrix (rows x nv).
  Eigen::SparseMatrix<double> matrix(int nv) const {
    std::vector<Eigen::Triplet<double>> entries;
    for (int r = 0; r < rows(); ++r) {
      const double* value = values(r);
      for (const int* k = columns(r); k != columns(r + 1); ++k) entries.emplace_back(r, *k, *value++);
    }
    Eigen::SparseMatrix<double> out(rows(), nv);
    out.setFromTriplets(entries.begin(), entries.end());
    return out;
  }
  // J as a full matrix (rows x nv), row by row.
  void write(std::vector<double>& J, int nv) const {
    J.assign(static_cast<std::size_t>(rows()) * nv, 0.0);
    for (int r = 0; r < rows(); ++r) scatter(r, J.data() + static_cast<std::size_t>(r) * nv);
  }

 private:
  std::vector<int> first_ = {0};
  std::vector<int> columns_;
  std::vector<double> values_;
};

}  // namespace gelenk
