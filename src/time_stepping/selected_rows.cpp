// SPDX-License-Identifier: BSD-3-Clause
#include "time_stepping/selected_rows.h"

#include <algorithm>

namespace gelenk {
namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

}  // namespace

void SelectedRows::reserve(std::size_t rows) {
  rows_.reserve(rows);
  matrix_.reserve(rows * rows);
  in_.reserve(rows);
  out_.reserve(rows);
}

void SelectedRows::select(const ConeOperator& all, std::span<const int> rows) {
  all_ = &all;
  rows_.assign(rows.begin(), rows.end());
  first_.clear();
  has_matrix_ = all.dense() != nullptr;
  if (has_matrix_) {
    copy_matrix();
  } else {
    copy_root();
  }
  in_.assign(index(all.size()), 0.0);
  out_.assign(index(all.size()), 0.0);
}

void SelectedRows::copy_matrix() {
  const double* from = all_->dense();
  matrix_.resize(rows_.size() * rows_.size());
  double* to = matrix_.data();
  for (const int column : rows_) {
    for (const int row : rows_) *to++ = from[index(column) * index(all_->size()) + index(row)];
  }
}

void SelectedRows::copy_root() {
  const ConeRoot from = all_->root();
  root_rows_ = from.rows;
  row_.clear();
  value_.clear();
  if (from.first.empty()) return;
  first_.push_back(0);
  for (const int column : rows_) {
    const std::size_t begin = index(from.first[index(column)]);
    const std::size_t count = index(from.first[index(column) + 1]) - begin;
    const auto rows = from.row.subspan(begin, count);
    const auto values = from.value.subspan(begin, count);
    row_.insert(row_.end(), rows.begin(), rows.end());
    value_.insert(value_.end(), values.begin(), values.end());
    first_.push_back(static_cast<int>(row_.size()));
  }
}

void SelectedRows::apply(const double* x, double* y) const {
  for (std::size_t i = 0; i < rows_.size(); ++i) in_[index(rows_[i])] = x[i];
  all_->apply(in_.data(), out_.data());
  for (std::size_t i = 0; i < rows_.size(); ++i) y[i] = out_[index(rows_[i])];
}

void SelectedRows::diagonal_block(const Cone& cone, double* out) const {
  all_->diagonal_block(Cone::within(rows_[index(cone.first)], 0, 0), out);
}

}  // namespace gelenk
