// SPDX-License-Identifier: BSD-3-Clause
#include "linear/augmented_mass.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "linear/columns.h"

namespace gelenk {
namespace {

// Pivots below this fraction of their diagonal entry are rounding: a pivot is what remains after subtracting numbers of
// the size of the diagonal, with an error of eps = 2e-16 of it times the number of terms.
constexpr double pivot_threshold = 1e-13;

}  // namespace

AugmentedMass::AugmentedMass(const std::vector<int>& parent, const SparseRows& J)
    : M_(parent), J_(J), scale_(J.rows()), diagonal_(parent.size()), massless_motion_(parent.size()) {}

// The elimination tree (Liu 1990), from the last velocity to the first. Paths to the ground and constraint equations
// are cliques; of each clique the neighbors suffice.
std::vector<int> AugmentedMass::pattern() const {
  const int n = M_.size();
  std::vector<std::vector<int>> outer(n);  // by velocity: its outward neighbors
  for (int k = 0; k < n; ++k) {
    if (M_.depth(k) > 0) outer[M_.ancestors(k)[M_.depth(k) - 1]].push_back(k);
  }
  for (int r = 0; r < J_.rows(); ++r) {
    std::vector<int> columns(J_.columns(r), J_.columns(r) + J_.entries(r));
    std::ranges::sort(columns);
    for (std::size_t i = 1; i < columns.size(); ++i) outer[columns[i - 1]].push_back(columns[i]);
  }
  std::vector<int> parent(n, -1);
  std::vector<int> root(n, -1);  // path compression
  for (int k = n - 1; k >= 0; --k) {
    for (int i : outer[k]) {
      while (root[i] >= 0 && root[i] != k) i = std::exchange(root[i], k);
      if (root[i] < 0 && i != k) root[i] = parent[i] = k;
    }
  }
  return parent;
}

// Each constraint equation is weighted by the inertia that it moves: 1/s = sum J_k^2 / M_kk over the velocities with
// inertia, so that s J^T J does not exceed M there and M's digits survive the sum. An equation between massless parts
// gets the smallest of these weights.
void AugmentedMass::choose_scales() {
  double largest = 0;
  const auto moment = [this](int k) { return M_.row(k)[M_.depth(k)]; };
  for (int k = 0; k < M_.size(); ++k) largest = std::max(largest, moment(k));
  double min_scale = std::numeric_limits<double>::infinity();
  for (int r = 0; r < J_.rows(); ++r) {
    double inverse_inertia = 0;
    for (int i = 0; i < J_.entries(r); ++i) {
      const double m = moment(J_.columns(r)[i]);
      const double j = J_.values(r)[i];
      if (m > inertia_threshold * largest) inverse_inertia += j * j / m;
    }
    scale_[r] = inverse_inertia > 0 ? 1 / inverse_inertia : 0;
    if (inverse_inertia > 0) min_scale = std::min(min_scale, scale_[r]);
  }
  if (!std::isfinite(min_scale)) min_scale = largest > 0 ? largest : 1;
  for (double& s : scale_) {
    if (s == 0) s = min_scale;
  }
}

void AugmentedMass::assemble(SparseFactor& sum) {
  choose_scales();
  for (int k = 0; k < sum.size(); ++k) {
    double* row = sum.row(k);
    std::fill(row, row + sum.depth(k) + 1, 0.0);
    for (int d = 0; d <= M_.depth(k); ++d) row[sum.depth(M_.ancestors(k)[d])] = M_.row(k)[d];
  }
  for (int r = 0; r < J_.rows(); ++r) {
    const int* column = J_.columns(r);
    const double* value = J_.values(r);
    for (int i = 0; i < J_.entries(r); ++i) {
      for (int j = 0; j <= i; ++j) {
        const int outer = std::max(column[i], column[j]);
        sum.row(outer)[sum.depth(std::min(column[i], column[j]))] += scale_[r] * value[i] * value[j];
      }
    }
  }
}

bool AugmentedMass::factorize(SparseFactor& sum) {
  for (int k = 0; k < sum.size(); ++k) diagonal_[k] = sum.row(k)[sum.depth(k)];
  int failed = sum.factorize();
  for (int k = sum.size() - 1; k >= 0 && failed < 0; --k) {
    const double root = sum.row(k)[sum.depth(k)];
    if (root * root <= pivot_threshold * diagonal_[k]) failed = k;
  }
  if (failed >= 0) sum.null_motion(failed, massless_motion_.data());
  return failed < 0;
}

void AugmentedMass::add_right_side(const double* gamma, double* f, int columns) const {
  for (int r = 0; r < J_.rows(); ++r) {
    const double* g = gamma + static_cast<std::size_t>(r) * columns;
    for (int i = 0; i < J_.entries(r); ++i) {
      columns::add(scale_[r] * J_.values(r)[i], g, f + static_cast<std::size_t>(J_.columns(r)[i]) * columns, columns);
    }
  }
}

}  // namespace gelenk
