// SPDX-License-Identifier: BSD-3-Clause
#include "linear/joined_mass.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "linear/columns.h"

namespace gelenk {
namespace {

// Of the diagonal. A pivot is left by subtracting numbers of the diagonal's size, so that eps = 2e-16 of it, times the
// number of terms, is rounding.
constexpr double least_pivot = 1e-13;

}  // namespace

JoinedMass::JoinedMass(const std::vector<int>& parent, const SparseRows& J)
    : tree_(parent), J_(J), scale_(J.rows()), diagonal_(parent.size()), motion_(parent.size()) {}

// The elimination tree (Liu 1990), from the last speed to the first. Ways to the ground and rows are cliques; of each
// it is enough to look at neighbours.
std::vector<int> JoinedMass::pattern() const {
  const int n = tree_.size();
  std::vector<std::vector<int>> outer(n);  // by speed: its neighbours outwards
  for (int k = 0; k < n; ++k) {
    if (tree_.depth(k) > 0) outer[tree_.ancestors(k)[tree_.depth(k) - 1]].push_back(k);
  }
  for (int r = 0; r < J_.rows(); ++r) {
    std::vector<int> speeds(J_.speeds(r), J_.speeds(r) + J_.entries(r));
    std::ranges::sort(speeds);
    for (std::size_t i = 1; i < speeds.size(); ++i) outer[speeds[i - 1]].push_back(speeds[i]);
  }
  std::vector<int> parent(n, -1);
  std::vector<int> root(n, -1);  // short cuts inwards
  for (int k = n - 1; k >= 0; --k) {
    for (int i : outer[k]) {
      while (root[i] >= 0 && root[i] != k) i = std::exchange(root[i], k);
      if (root[i] < 0 && i != k) root[i] = parent[i] = k;
    }
  }
  return parent;
}

// Each row weighs what it moves: 1/s = sum J_k^2 / M_kk over the speeds that have inertia, so that s J^T J is not above
// M there and the sum's digits are not budget_exhausted on the rows. A row between parts without inertia weighs as the
// lightest.
void JoinedMass::choose_scales() {
  double largest = 0;
  const auto moment = [this](int k) { return tree_.row(k)[tree_.depth(k)]; };
  for (int k = 0; k < tree_.size(); ++k) largest = std::max(largest, moment(k));
  double lightest = std::numeric_limits<double>::infinity();
  for (int r = 0; r < J_.rows(); ++r) {
    double yield = 0;
    for (int i = 0; i < J_.entries(r); ++i) {
      const double m = moment(J_.speeds(r)[i]);
      const double j = J_.values(r)[i];
      if (m > no_inertia * largest) yield += j * j / m;
    }
    scale_[r] = yield > 0 ? 1 / yield : 0;
    if (yield > 0) lightest = std::min(lightest, scale_[r]);
  }
  if (!std::isfinite(lightest)) lightest = largest > 0 ? largest : 1;
  for (double& s : scale_) {
    if (s == 0) s = lightest;
  }
}

void JoinedMass::join(SparseFactor& sum) {
  choose_scales();
  for (int k = 0; k < sum.size(); ++k) {
    double* row = sum.row(k);
    std::fill(row, row + sum.depth(k) + 1, 0.0);
    for (int d = 0; d <= tree_.depth(k); ++d) row[sum.depth(tree_.ancestors(k)[d])] = tree_.row(k)[d];
  }
  for (int r = 0; r < J_.rows(); ++r) {
    const int* speed = J_.speeds(r);
    const double* value = J_.values(r);
    for (int i = 0; i < J_.entries(r); ++i) {
      for (int j = 0; j <= i; ++j) {
        const int outer = std::max(speed[i], speed[j]);
        sum.row(outer)[sum.depth(std::min(speed[i], speed[j]))] += scale_[r] * value[i] * value[j];
      }
    }
  }
}

bool JoinedMass::factorize(SparseFactor& sum) {
  for (int k = 0; k < sum.size(); ++k) diagonal_[k] = sum.row(k)[sum.depth(k)];
  int failed = sum.factorize();
  for (int k = sum.size() - 1; k >= 0 && failed < 0; --k) {
    const double root = sum.row(k)[sum.depth(k)];
    if (root * root <= least_pivot * diagonal_[k]) failed = k;
  }
  if (failed >= 0) sum.null_motion(failed, motion_.data());
  return failed < 0;
}

void JoinedMass::add(const double* gamma, double* f, int columns) const {
  for (int r = 0; r < J_.rows(); ++r) {
    const double* g = gamma + static_cast<std::size_t>(r) * columns;
    for (int i = 0; i < J_.entries(r); ++i) {
      columns::add(scale_[r] * J_.values(r)[i], g, f + static_cast<std::size_t>(J_.speeds(r)[i]) * columns, columns);
    }
  }
}

}  // namespace gelenk
