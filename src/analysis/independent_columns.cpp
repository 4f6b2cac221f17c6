// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/independent_columns.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::SparseMatrix;

// As shares of the largest entry: pivots that are good, and those below which a row is rounding.
constexpr double sound = 1e-3;
constexpr double rounding = 1e-8;
constexpr double nothing = 1e-14;  // entries up to this are 0

// Gaussian elimination with full pivoting, by which columns become dependent. Rows hold their entries that are not
// zero, and a step goes to those alone that have one in its column, so that sparse rows cost what they hold.
class Elimination {
 public:
  Elimination(const SparseMatrix<double>& J, const std::vector<bool>& spared)
      : rows_(J.rows()),
        holders_(J.cols()),
        open_(J.cols()),
        dependent_(J.cols(), false),
        used_(J.rows(), false),
        largest_(J.nonZeros() > 0 ? J.coeffs().abs().maxCoeff() : 0),
        best_(J.rows()) {
    for (Index k = 0; k < J.cols(); ++k) open_[k] = !spared[k];
    for (Index k = 0; k < J.outerSize(); ++k) {
      for (SparseMatrix<double>::InnerIterator at(J, k); at; ++at) {
        if (std::abs(at.value()) <= nothing * largest_) continue;
        rows_[at.row()].push_back({k, at.value()});
        holders_[k].push_back(at.row());
      }
    }
    look_at_all();
  }

  // From now on spared columns may be taken, too.
  void take_all() {
    for (std::size_t k = 0; k < open_.size(); ++k) open_[k] = !dependent_[k];
    look_at_all();
  }

  // Takes the largest entry there is, of equal ones that of the first row. False: none is above this share of the
  // largest at first.
  bool step(double least) {
    if (by_size_.empty()) return false;
    const auto [negative, row] = *by_size_.begin();
    if (!(-negative > least * largest_)) return false;
    const Entry pivot = best_[row];
    leave(row);
    used_[row] = true;
    dependent_[pivot.column] = true;
    open_[pivot.column] = false;
    const std::vector<Index> holders = std::move(holders_[pivot.column]);
    for (const Index r : holders) {
      if (used_[r]) continue;  // it has chosen
      const auto own = find(rows_[r], pivot.column);
      if (own == rows_[r].end() || own->column != pivot.column) continue;
      subtract(r, own->value / pivot.value, row, pivot.column);
      look(r);
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

  // Row r loses `factor` times another and its entry in this column, which vanishes.
  void subtract(Index r, double factor, Index other, Index column) {
    Row sum;
    auto a = rows_[r].begin();
    for (const Entry& b : rows_[other]) {
      while (a != rows_[r].end() && a->column < b.column) sum.push_back(*a++);
      const bool both = a != rows_[r].end() && a->column == b.column;
      if (!both) holders_[b.column].push_back(r);
      const double value = (both ? a->value : 0) - factor * b.value;
      if (both) ++a;
      if (b.column != column && std::abs(value) > nothing * largest_) sum.push_back({b.column, value});
    }
    sum.insert(sum.end(), a, rows_[r].end());
    rows_[r] = std::move(sum);
  }

  void look_at_all() {
    for (Index r = 0; r < static_cast<Index>(rows_.size()); ++r) {
      if (!used_[r]) look(r);
    }
  }

  // The largest open entry of row r, the first of equal ones.
  void look(Index r) {
    leave(r);
    best_[r] = {};
    for (const Entry& entry : rows_[r]) {
      if (open_[entry.column] && std::abs(entry.value) > std::abs(best_[r].value)) best_[r] = entry;
    }
    if (best_[r].column >= 0) by_size_.emplace(-std::abs(best_[r].value), r);
  }

  void leave(Index r) { by_size_.erase({-std::abs(best_[r].value), r}); }

  std::vector<Row> rows_;
  std::vector<std::vector<Index>> holders_;  // by column: rows that have, or had, an entry there
  std::vector<bool> open_, dependent_, used_;
  double largest_;
  std::vector<Entry> best_;                     // by row: its largest open entry
  std::set<std::pair<double, Index>> by_size_;  // of rows not used, the largest first
};

}  // namespace

std::vector<int> independent_columns(const SparseMatrix<double>& J, int rank, const std::vector<bool>& prefer) {
  Elimination elimination(J, prefer);
  // Those nobody asked for become dependent first.
  for (int step = 0, pass = 0; step < rank && pass < 2;) {
    if (elimination.step(pass == 0 ? sound : rounding)) {
      ++step;
    } else {
      ++pass;
      elimination.take_all();
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
  // Where a speed is independent its coordinate can be, too.
  std::vector<bool> prefer = coordinates;
  for (const int k : out.speeds) prefer[k] = prefer[k] || coordinates == speeds;
  out.coordinates = independent_columns(position_rows(mechanism, dynamics.sparse_J()), mobility.position_rank, prefer);
  return out;
}

}  // namespace gelenk
