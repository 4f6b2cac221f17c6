// SPDX-License-Identifier: BSD-3-Clause
#include "time_stepping/recorded_problem.h"

#include <algorithm>
#include <utility>

namespace gelenk {
namespace {

Eigen::MatrixXd formed(const ConeOperator& of) {
  const Eigen::Index n = of.size();
  Eigen::MatrixXd G(n, n);
  Eigen::VectorXd unit = Eigen::VectorXd::Zero(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    unit[j] = 1;
    of.apply(unit.data(), G.col(j).data());
    unit[j] = 0;
  }
  return G;
}

}  // namespace

RecordedProblem::RecordedProblem(const ConeProblem& of)
    : b_(of.b.begin(), of.b.end()), cones_(of.cones.begin(), of.cones.end()) {
  const ConeRoot root = of.G.root();
  root_rows_ = root.rows;
  first_.assign(root.first.begin(), root.first.end());
  row_.assign(root.row.begin(), root.row.end());
  value_.assign(root.value.begin(), root.value.end());
  const Eigen::Index n = of.G.size();
  if (of.G.dense() != nullptr) {
    G_ = Eigen::Map<const Eigen::MatrixXd>(of.G.dense(), n, n);
  } else if (first_.empty()) {
    G_ = formed(of.G);
  }
}

RecordedProblem::RecordedProblem(const Eigen::MatrixXd& G, const Eigen::VectorXd& b, std::vector<Cone> cones)
    : G_(G), b_(b.begin(), b.end()), cones_(std::move(cones)) {}

Eigen::MatrixXd RecordedProblem::matrix() const { return has_matrix() ? G_ : formed(*this); }

RecordedProblem RecordedProblem::without_matrix() const {
  RecordedProblem out = *this;
  if (!first_.empty()) out.G_.resize(0, 0);
  return out;
}

void RecordedProblem::apply(const double* x, double* y) const {
  const int n = size();
  if (has_matrix()) return DenseConeOperator(G_).apply(x, y);
  std::vector<double> Wx(static_cast<std::size_t>(root_rows_), 0.0);
  for (int j = 0; j < n; ++j) {
    for (int k = begin(j); k < end(j); ++k)
      Wx[static_cast<std::size_t>(row_[static_cast<std::size_t>(k)])] += value_[static_cast<std::size_t>(k)] * x[j];
  }
  for (int j = 0; j < n; ++j) {
    y[j] = 0;
    for (int k = begin(j); k < end(j); ++k)
      y[j] += value_[static_cast<std::size_t>(k)] * Wx[static_cast<std::size_t>(row_[static_cast<std::size_t>(k)])];
  }
}

void RecordedProblem::diagonal_block(const Cone& cone, double* out) const {
  if (has_matrix()) return DenseConeOperator(G_).diagonal_block(cone, out);
  const int n = cone.size();
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) out[i * n + j] = product_of_columns(cone.first + i, cone.first + j);
  }
}

double RecordedProblem::product_of_columns(int i, int j) const {
  double sum = 0;
  for (int k = begin(i), l = begin(j); k < end(i) && l < end(j);) {
    const int of_i = row_[static_cast<std::size_t>(k)];
    const int of_j = row_[static_cast<std::size_t>(l)];
    if (of_i == of_j) sum += value_[static_cast<std::size_t>(k)] * value_[static_cast<std::size_t>(l)];
    k += of_i <= of_j ? 1 : 0;
    l += of_j <= of_i ? 1 : 0;
  }
  return sum;
}

}  // namespace gelenk
