// SPDX-License-Identifier: BSD-3-Clause
#include "recorded/pivots.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

namespace gelenk {
namespace {

constexpr double dependent = 1e-7;  // what is left of an equation of size 1 that follows from others
// Entries of J [m or rad, by m or rad], which are sums of products of directions and lengths, below which a whole
// equation is rounding: 0 = 0 for what is closed in all motions of the others.
constexpr double rounding = 1e-10;
// Pivots of another position are chosen if the smallest is so many times that of the first ones.
constexpr double much_larger = 10;

// How far positions are from the start [rad or m].
constexpr double neighborhoods[] = {0, 0.05, 0.05, 0.05, 0.2, 0.2, 0.2, 0.8, 0.8, 0.8};

// By elimination with complete pivoting.
Pivots largest(RowMatrix J, Eigen::Index rank) {
  Pivots out;
  for (Eigen::Index n = 0; n < std::min({rank, J.rows(), J.cols()}); ++n) {
    Eigen::Index row = 0;
    Eigen::Index column = 0;
    if (!(J.cwiseAbs().maxCoeff(&row, &column) > dependent)) break;
    out.rows.push_back(static_cast<int>(row));
    out.columns.push_back(static_cast<int>(column));
    const Eigen::RowVectorXd pivot = J.row(row) / J(row, column);
    for (Eigen::Index r = 0; r < J.rows(); ++r) J.row(r) -= J(r, column) * pivot;
    J.row(row).setZero();
    J.col(column).setZero();
  }
  return out;
}

// The smallest pivot of these, in this order; 0 if one vanishes.
double smallest_pivot(RowMatrix J, const Pivots& pivots) {
  double out = std::numeric_limits<double>::infinity();
  for (std::size_t n = 0; n < pivots.rows.size(); ++n) {
    const double pivot = J(pivots.rows[n], pivots.columns[n]);
    out = std::min(out, std::abs(pivot));
    if (!(out > 0)) return 0;
    const Eigen::RowVectorXd row = J.row(pivots.rows[n]) / pivot;
    for (std::size_t k = n + 1; k < pivots.rows.size(); ++k)
      J.row(pivots.rows[k]) -= J(pivots.rows[k], pivots.columns[n]) * row;
  }
  return out;
}

}  // namespace

std::vector<std::vector<double>> positions_around(const std::vector<double>& start) {
  std::mt19937 random(1);  // its numbers are the same everywhere, those of distributions are not
  std::vector<std::vector<double>> out;
  for (const double around : neighborhoods) {
    std::vector<double>& q = out.emplace_back(start);
    for (double& x : q)
      x += around * (2 * static_cast<double>(random()) / static_cast<double>(std::mt19937::max()) - 1);
  }
  return out;
}

RowMatrix equilibrated(const Eigen::Ref<const RowMatrix>& M, RowMatrix J) {
  if (J.size() == 0) return J;
  for (Eigen::Index r = 0; r < J.rows(); ++r) {
    if (J.row(r).cwiseAbs().maxCoeff() < rounding) J.row(r).setZero();
  }
  for (Eigen::Index c = 0; c < J.cols(); ++c) J.col(c) /= M(c, c) > 0 ? std::sqrt(M(c, c)) : 1;
  const double largest_row = J.cwiseAbs().maxCoeff();
  if (largest_row == 0) return J;
  for (Eigen::Index r = 0; r < J.rows(); ++r) {
    const double size = J.row(r).cwiseAbs().maxCoeff();
    J.row(r) /= size > dependent * largest_row ? size : largest_row;
  }
  return J;
}

Pivots choose_pivots(std::span<const RowMatrix> equilibrated_at, int rank, std::size_t& usual) {
  Pivots out;
  double smallest = 0;
  for (const RowMatrix& J : equilibrated_at) {
    Pivots here = largest(J, rank);
    const double size = smallest_pivot(J, here);
    const bool has_more = here.rows.size() > out.rows.size();
    if (!has_more && (here.rows.size() < out.rows.size() || size < much_larger * smallest)) continue;
    smallest = size;
    out = std::move(here);
  }
  if (out.rows.empty()) return out;
  double best = 0;
  for (std::size_t k = 0; k < equilibrated_at.size(); ++k) {
    const double size = smallest_pivot(equilibrated_at[k], out);
    if (size <= best) continue;
    best = size;
    usual = k;
  }
  return out;
}

}  // namespace gelenk
