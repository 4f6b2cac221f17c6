// SPDX-License-Identifier: BSD-3-Clause
// M = L^T L of a mechanism at the position the workspace holds: written down branch by branch, or, where branches are
// long, applied by recursions in the time that one pass along the tree takes.
#pragma once

#include <algorithm>
#include <optional>
#include <set>
#include <vector>

#include "dynamics/articulated_factor.h"
#include "dynamics/kernels.h"
#include "dynamics/sparse_factor.h"

namespace gelenk {

// parent[k]: the speed before k on the way to the ground, -1 at the ground.
template <class A>
std::vector<int> speed_parents(const Model<A>& model) {
  std::vector<int> parent(model.nv, -1);
  std::vector<int> last(model.links.size(), -1);  // by link: its outermost speed, or its ancestors'
  for (std::size_t i = 1; i < model.links.size(); ++i) {
    const auto& link = model.links[i];
    int before = last[link.parent];
    for (int k = link.iv; k < link.iv + link.nv; ++k) {
      parent[k] = before;
      before = k;
    }
    last[i] = before;
  }
  return parent;
}

template <class A>
class MassFactor {
 public:
  // As ArticulatedFactor. added: to the diagonal of M, by speed.
  MassFactor(const Model<A>& model, Workspace<A>& ws, const std::vector<double>& added)
      : model_(model), ws_(ws), added_(added), written_(speed_parents(model)) {
    long entries = 0;
    for (int k = 0; k < model.nv; ++k) entries += written_.depth(k);
    if (entries > longest_written * model.nv) applied_.emplace(model, ws);
  }

  // Returns -1, or the speed at which M has no inertia.
  int factorise() {
    current_ = false;
    if (applied_) return applied_->factorise(added_);
    write();
    return written_.factorise();
  }
  void solve_transposed(double* x) const {  // x <- L^-T x: whitens a generalised force
    applied_ ? applied_->solve_transposed(x) : written_.solve_transposed(x);
  }
  // The same for an x with zeros but at these speeds, see inwards().
  void solve_transposed(double* x, const std::vector<int>& speeds) const {
    applied_ ? applied_->solve_transposed(x) : written_.solve_transposed(x, speeds);
  }
  // These speeds and all inwards of them, ascending.
  std::vector<int> inwards(const int* speeds, int count) const {
    std::set<int> out;
    for (const int* k = speeds; k != speeds + count; ++k) {
      out.insert(written_.ancestors(*k), written_.ancestors(*k) + written_.depth(*k) + 1);
    }
    return {out.begin(), out.end()};
  }
  void solve(double* x) const {  // x <- L^-1 x: from whitened to speeds
    applied_ ? applied_->solve(x) : written_.solve(x);
  }
  // The same for the columns of x, which is stored row by row; ws still at the position of the factors.
  void solve_transposed(double* x, int columns) const {
    written_down() ? written_.solve_transposed(x, columns) : applied_->solve_transposed(x, columns);
  }
  void solve(double* x, int columns) const {
    written_down() ? written_.solve(x, columns) : applied_->solve(x, columns);
  }
  void multiply(const double* x, double* y) const {  // y = L x: whitens speeds
    applied_ ? applied_->multiply(x, y) : written_.multiply(x, y);
  }

  // M, nv x nv. The factors are lost.
  void matrix(double* M) {
    current_ = false;
    write();
    const int n = model_.nv;
    std::fill(M, M + static_cast<std::size_t>(n) * n, 0.0);
    for (int i = 0; i < n; ++i) {
      const double* row = written_.row(i);
      const int* column = written_.ancestors(i);
      for (int d = 0; d <= written_.depth(i); ++d) M[i * n + column[d]] = M[column[d] * n + i] = row[d];
    }
  }

 private:
  // Mean number of speeds inside of one, above which recursions take less time: measured on chains.
  static constexpr long longest_written = 5;

  // For many columns it pays to write down what else is applied, up to this many speeds.
  static constexpr int most_written = 256;
  bool written_down() const {
    if (!applied_) return true;
    if (!current_ && model_.nv <= most_written) {
      write();
      current_ = written_.factorise() < 0;
    }
    return current_;
  }

  void write() const {
    kernels::mass_matrix(model_, ws_, written_);
    for (int k = 0; k < model_.nv; ++k) written_.row(k)[written_.depth(k)] += added_[k];
  }

  const Model<A>& model_;
  Workspace<A>& ws_;
  const std::vector<double>& added_;
  mutable SparseFactor written_;
  mutable bool current_ = false;  // written_ has what is applied
  std::optional<ArticulatedFactor<A>> applied_;
};

}  // namespace gelenk
