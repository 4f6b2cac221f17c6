// SPDX-License-Identifier: BSD-3-Clause
// J by rows, without the speeds that a row does not feel: a loop feels those between its two ends and their nearest
// common ancestor. The pattern is found once.
#pragma once

#include <Eigen/SparseCore>
#include <algorithm>
#include <vector>

namespace gelenk {

class SparseRows {
 public:
  // Appends a row that feels these speeds, in any order.
  void append(const std::vector<int>& speeds) {
    speeds_.insert(speeds_.end(), speeds.begin(), speeds.end());
    values_.resize(speeds_.size(), 0.0);
    first_.push_back(static_cast<int>(speeds_.size()));
  }

  int rows() const { return static_cast<int>(first_.size()) - 1; }
  int entries(int row) const { return first_[row + 1] - first_[row]; }
  const int* speeds(int row) const { return speeds_.data() + first_[row]; }
  double* values(int row) { return values_.data() + first_[row]; }
  const double* values(int row) const { return values_.data() + first_[row]; }

  // x[speed] <- the row's entries; the others are left.
  void scatter(int row, double* x) const {
    const double* value = values(row);
    for (const int* k = speeds(row); k != speeds(row + 1); ++k) x[*k] = *value++;
  }
  // rows x nv.
  Eigen::SparseMatrix<double> matrix(int nv) const {
    std::vector<Eigen::Triplet<double>> entries;
    for (int r = 0; r < rows(); ++r) {
      const double* value = values(r);
      for (const int* k = speeds(r); k != speeds(r + 1); ++k) entries.emplace_back(r, *k, *value++);
    }
    Eigen::SparseMatrix<double> out(rows(), nv);
    out.setFromTriplets(entries.begin(), entries.end());
    return out;
  }
  // The same row by row, zeros included.
  void write(std::vector<double>& J, int nv) const {
    J.assign(static_cast<std::size_t>(rows()) * nv, 0.0);
    for (int r = 0; r < rows(); ++r) scatter(r, J.data() + static_cast<std::size_t>(r) * nv);
  }

 private:
  std::vector<int> first_ = {0};
  std::vector<int> speeds_;
  std::vector<double> values_;
};

}  // namespace gelenk
