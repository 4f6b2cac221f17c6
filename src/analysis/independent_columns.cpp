// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/independent_columns.h"

#include <cmath>

namespace gelenk {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// As shares of the largest entry: pivots that are good, and those below which a row is rounding.
constexpr double sound = 1e-3;
constexpr double rounding = 1e-8;

// Gaussian elimination with full pivoting, by which columns become dependent. Rows that a step leaves alone keep their
// largest entry, so that sparse rows cost what they hold.
class Elimination {
 public:
  Elimination(const MatrixXd& J, const std::vector<bool>& spared)
      : J_(J), open_(J.cols()), largest_(J.size() > 0 ? J.lpNorm<Eigen::Infinity>() : 0), best_(J.rows(), -1) {
    for (Index k = 0; k < J.cols(); ++k) open_[k] = !spared[k];
    dependent_.assign(J.cols(), false);
    used_.assign(J.rows(), false);
    for (Index r = 0; r < J.rows(); ++r) look(r);
  }

  // From now on spared columns may be taken, too.
  void take_all() {
    for (Index k = 0; k < J_.cols(); ++k) open_[k] = !dependent_[k];
    for (Index r = 0; r < J_.rows(); ++r) look(r);
  }

  // Takes the largest entry there is. False: none is above this share of the largest at first.
  bool step(double least) {
    Index row = -1;
    double pivot = least * largest_;
    for (Index r = 0; r < J_.rows(); ++r) {
      if (used_[r] || best_[r] < 0 || !(std::abs(J_(r, best_[r])) > pivot)) continue;
      pivot = std::abs(J_(r, best_[r]));
      row = r;
    }
    if (row < 0) return false;
    const Index column = best_[row];
    used_[row] = dependent_[column] = true;
    open_[column] = false;
    for (Index r = 0; r < J_.rows(); ++r) {
      const double factor = J_(r, column) / J_(row, column);
      if (r == row || factor == 0) continue;
      J_.row(r) -= factor * J_.row(row);
      look(r);
    }
    return true;
  }

  std::vector<int> independent() const {
    std::vector<int> out;
    for (Index k = 0; k < J_.cols(); ++k) {
      if (!dependent_[k]) out.push_back(static_cast<int>(k));
    }
    return out;
  }

 private:
  void look(Index r) {
    best_[r] = -1;
    for (Index k = 0; k < J_.cols(); ++k) {
      if (open_[k] && (best_[r] < 0 || std::abs(J_(r, k)) > std::abs(J_(r, best_[r])))) best_[r] = k;
    }
  }

  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> J_;
  std::vector<bool> open_, dependent_, used_;
  double largest_;
  std::vector<Index> best_;  // by row: where its largest open entry is
};

}  // namespace

std::vector<int> independent_columns(const MatrixXd& J, int rank, const std::vector<bool>& prefer) {
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

}  // namespace gelenk
