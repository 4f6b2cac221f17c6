// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/independent_columns.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace gelenk {
namespace {

using Eigen::Index;

// Relative to the largest entry: good pivots, and pivots that are rounding.
constexpr double good_pivot_ratio = 1e-3;
constexpr double rounding_ratio = 1e-8;
constexpr double zero_entry_ratio = 1e-14;  // entries up to this are set to zero

// Gaussian elimination with full pivoting selects the dependent columns. Rows store nonzero entries only, and a step
// visits only rows with an entry in the pivot column, so the cost of sparse rows is that of their entries.
class Elimination {
 public:
  Elimination(const Eigen::SparseMatrix<double>& J, const std::vector<bool>& preferred)
      : rows_(J.rows()),
        holders_(J.cols()),
        eligible_(J.cols()),
        dependent_(J.cols(), false),
        used_(J.rows(), false),
        largest_(J.nonZeros() > 0 ? J.coeffs().abs().maxCoeff() : 0),
        best_(J.rows()) {
    for (Index k = 0; k < J.cols(); ++k) eligible_[k] = !preferred[k];
    for (Index k = 0; k < J.outerSize(); ++k) {
      for (Eigen::SparseMatrix<double>::InnerIterator at(J, k); at; ++at) {
        if (std::abs(at.value()) <= zero_entry_ratio * largest_) continue;
        rows_[at.row()].push_back({k, at.value()});
        holders_[k].push_back(at.row());
      }
    }
    update_all();
  }

  // Allows preferred columns as pivots, too.
  void allow_all() {
    for (std::size_t k = 0; k < eligible_.size(); ++k) eligible_[k] = !dependent_[k];
    update_all();
  }

  // Uses the largest entry as pivot, the first row among equal ones. Returns false if none exceeds this fraction of the
  // largest initial entry.
  bool step(double least) {
    if (by_size_.empty()) return false;
    const auto [negative, row] = *by_size_.begin();
    if (!(-negative > least * largest_)) return false;
    const Entry pivot = best_[row];
    remove_from_order(row);
    used_[row] = true;
    dependent_[pivot.column] = true;
    eligible_[pivot.column] = false;
    const std::vector<Index> holders = std::move(holders_[pivot.column]);
    for (const Index r : holders) {
      if (used_[r]) continue;  // it has been a pivot row
      const auto own = find(rows_[r], pivot.column);
      if (own == rows_[r].end() || own->column != pivot.column) continue;
      subtract(r, own->value / pivot.value, row, pivot.column);
      update_best(r);
    }
    return true;
  }

  std::vector<int> independent() const {
    std::vector<int> out;
    for (std::size_t k = 0; k < dependent_.size(); ++k) {
      if (!dependent_[k]) out.push_back(static_cast<int>(k));
    }
    return out;
  }

 private:
  struct Entry {
    Index column = -1;
    double value = 0;
  };
  using Row = std::vector<Entry>;  // by column

  static Row::iterator find(Row& row, Index column) {
    return std::ranges::lower_bound(row, column, {}, &Entry::column);
  }

  // Subtracts `factor` times another row from row r; its entry in this column vanishes.
  void subtract(Index r, double factor, Index other, Index column) {
    Row sum;
    auto a = rows_[r].begin();
    for (const Entry& b : rows_[other]) {
      while (a != rows_[r].end() && a->column < b.column) sum.push_back(*a++);
      const bool both = a != rows_[r].end() && a->column == b.column;
      if (!both) holders_[b.column].push_back(r);
      const double value = (both ? a->value : 0) - factor * b.value;
      if (both) ++a;
      if (b.column != column && std::abs(value) > zero_entry_ratio * largest_) sum.push_back({b.column, value});
    }
    sum.insert(sum.end(), a, rows_[r].end());
    rows_[r] = std::move(sum);
  }

  void update_all() {
    for (Index r = 0; r < static_cast<Index>(rows_.size()); ++r) {
      if (!used_[r]) update_best(r);
    }
  }

  // Finds the largest eligible entry of row r, the first of equal ones.
  void update_best(Index r) {
    remove_from_order(r);
    best_[r] = {};
    for (const Entry& entry : rows_[r]) {
      if (eligible_[entry.column] && std::abs(entry.value) > std::abs(best_[r].value)) best_[r] = entry;
    }
    if (best_[r].column >= 0) by_size_.emplace(-std::abs(best_[r].value), r);
  }

  void remove_from_order(Index r) { by_size_.erase({-std::abs(best_[r].value), r}); }

  std::vector<Row> rows_;
  std::vector<std::vector<Index>> holders_;  // by column: rows that have, or had, an entry there
  std::vector<bool> eligible_, dependent_, used_;
  double largest_;
  std::vector<Entry> best_;                     // by row: its largest eligible entry
  std::set<std::pair<double, Index>> by_size_;  // pivot candidates of unused rows, largest first
};

}  // namespace

std::vector<int> independent_columns(const Eigen::SparseMatrix<double>& J, int rank, const std::vector<bool>& prefer) {
  Elimination elimination(J, prefer);
  // Columns that are not preferred become dependent first.
  for (int step = 0, pass = 0; step < rank && pass < 2;) {
    if (elimination.step(pass == 0 ? good_pivot_ratio : rounding_ratio)) {
      ++step;
    } else {
      ++pass;
      elimination.allow_all();
    }
  }
  return elimination.independent();
}

Independent independent_at(const Mechanism& mechanism, Dynamics& dynamics, const MobilityAnalysis& mobility,
                           const std::vector<bool>& coordinates, const std::vector<bool>& speeds) {
  Independent out;
  out.speeds = independent_columns(dynamics.sparse_J(), mobility.rank, speeds);
  out.coordinates = out.speeds;
  if (mobility.position_rank == mobility.rank && coordinates == speeds) return out;
  // If a velocity is independent, its coordinate can be, too.
  std::vector<bool> prefer = coordinates;
  for (const int k : out.speeds) prefer[k] = prefer[k] || coordinates == speeds;
  out.coordinates = independent_columns(position_rows(mechanism, dynamics.sparse_J()), mobility.position_rank, prefer);
  return out;
}

}  // namespace gelenk
