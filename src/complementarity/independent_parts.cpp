// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/independent_parts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace gelenk {
namespace {

// Whether they follow each other without gaps, as ConeProblem asks.
bool fits(const ConeProblem& problem) {
  int next = 0;
  for (const Cone& cone : problem.cones) {
    if (cone.first != next) return false;
    next += cone.size();
  }
  return next == problem.G.size() && problem.b.size() == static_cast<std::size_t>(next);
}

}  // namespace

void PartOfOperator::restrict(const ConeOperator& whole, std::span<const int> unknowns) {
  size_ = static_cast<int>(unknowns.size());
  first_.clear();
  const double* const all = whole.dense();
  is_dense_ = all != nullptr || size_ <= most_with_matrix_and_root;
  if (is_dense_) numbers_.resize(unknowns.size() * unknowns.size());
  if (all == nullptr) {
    take_root(whole.root(), unknowns);
    if (is_dense_) multiply_root();
    return;
  }
  const auto n = static_cast<std::size_t>(whole.size());
  std::size_t k = 0;
  for (const int j : unknowns) {
    for (const int i : unknowns) numbers_[k++] = all[n * static_cast<std::size_t>(j) + static_cast<std::size_t>(i)];
  }
}

// Without the rows that none of the unknowns reaches.
void PartOfOperator::take_root(const ConeRoot& of, std::span<const int> unknowns) {
  number_of_row_.assign(static_cast<std::size_t>(of.rows), -1);
  for (const int unknown : unknowns) {
    for (const int row : of.column(unknown).row) number_of_row_[static_cast<std::size_t>(row)] = 0;
  }
  rows_ = 0;
  for (int& number : number_of_row_) {
    if (number == 0) number = rows_++;
  }
  row_.clear();
  value_.clear();
  first_.assign(1, 0);
  for (const int unknown : unknowns) {
    const ConeRoot::Column column = of.column(unknown);
    for (const int row : column.row) row_.push_back(number_of_row_[static_cast<std::size_t>(row)]);
    value_.insert(value_.end(), column.value.begin(), column.value.end());
    first_.push_back(static_cast<int>(row_.size()));
  }
  image_.resize(static_cast<std::size_t>(rows_));
}

ConeRoot PartOfOperator::root() const {
  if (first_.empty()) return {};
  return {rows_, first_, row_, value_};
}

// Of columns of the root, whose rows ascend.
double PartOfOperator::product(int i, int j) const {
  const ConeRoot::Column a = root().column(i);
  const ConeRoot::Column b = root().column(j);
  double sum = 0;
  for (std::size_t k = 0, l = 0; k < a.row.size() && l < b.row.size();) {
    if (a.row[k] == b.row[l]) {
      sum += a.value[k++] * b.value[l++];
    } else {
      ++(a.row[k] < b.row[l] ? k : l);
    }
  }
  return sum;
}

void PartOfOperator::multiply_root() {
  Eigen::Map<Eigen::MatrixXd> G(numbers_.data(), size_, size_);
  for (int j = 0; j < size_; ++j) {
    for (int i = 0; i <= j; ++i) G(i, j) = G(j, i) = product(i, j);
  }
}

void PartOfOperator::apply(const double* x, double* y) const {
  if (is_dense_) {
    Eigen::Map<Eigen::VectorXd>(y, size_).noalias() =
        Eigen::Map<const Eigen::MatrixXd>(numbers_.data(), size_, size_) * Eigen::Map<const Eigen::VectorXd>(x, size_);
    return;
  }
  std::ranges::fill(image_, 0.0);
  for (int j = 0; j < size_; ++j) {
    const ConeRoot::Column column = root().column(j);
    for (std::size_t k = 0; k < column.row.size(); ++k)
      image_[static_cast<std::size_t>(column.row[k])] += column.value[k] * x[j];
  }
  for (int j = 0; j < size_; ++j) {
    const ConeRoot::Column column = root().column(j);
    y[j] = 0;
    for (std::size_t k = 0; k < column.row.size(); ++k)
      y[j] += column.value[k] * image_[static_cast<std::size_t>(column.row[k])];
  }
}

void PartOfOperator::diagonal_block(const Cone& cone, double* out) const {
  const int n = cone.size();
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const int row = cone.first + i;
      const int column = cone.first + j;
      *out++ = is_dense_ ? numbers_[static_cast<std::size_t>(column) * static_cast<std::size_t>(size_) +
                                    static_cast<std::size_t>(row)]
                         : product(row, column);
    }
  }
}

// cones: some of those by part.
ConeResult IndependentParts::solve_part(const ConeProblem& problem, const ConeOptions& options,
                                        std::span<const std::pair<int, int>> cones) {
  unknowns_.clear();
  cones_.clear();
  b_.clear();
  x_.clear();
  for (const auto& [part, number] : cones) {
    const Cone& cone = problem.cones[static_cast<std::size_t>(number)];
    cones_.push_back(cone);
    cones_.back().first = static_cast<int>(unknowns_.size());
    for (int unknown = cone.first; unknown < cone.first + cone.size(); ++unknown) {
      unknowns_.push_back(unknown);
      b_.push_back(problem.b[static_cast<std::size_t>(unknown)]);
      x_.push_back(found_[static_cast<std::size_t>(unknown)]);
    }
  }
  operator_.restrict(problem.G, unknowns_);
  const ConeResult result = of_parts_->solve({operator_, b_, cones_, problem.exact_coulomb}, options, x_.data());
  for (std::size_t i = 0; i < unknowns_.size(); ++i) found_[static_cast<std::size_t>(unknowns_[i])] = x_[i];
  return result;
}

ConeResult IndependentParts::solve(const ConeProblem& problem, const ConeOptions& options, double* x) {
  if (problem.cones.size() < 2 || !fits(problem) || !parts_.divide(problem))
    return of_parts_->solve(problem, options, x);
  found_.assign(x, x + problem.G.size());
  ConeResult out{.converged = true};
  each_part_of(parts_.by_part(), [&](std::span<const std::pair<int, int>> cones) {
    const ConeResult result = solve_part(problem, options, cones);
    out.residual = std::max(out.residual, result.residual);
    out.iterations = std::max(out.iterations, result.iterations);
    out.products += result.products;
    out.converged = out.converged && result.converged;
  });
  if (std::isfinite(out.residual)) std::ranges::copy(found_, x);
  return out;
}

}  // namespace gelenk
