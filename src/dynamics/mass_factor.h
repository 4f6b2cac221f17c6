// SPDX-License-Identifier: BSD-3-Clause
// M = L^T L of a mechanism at the position the workspace holds: written down branch by branch, or, where branches are
// long, applied by recursions in the time that one pass along the tree takes. Where M needs the rows (Mechanism), L is
// that of M and the rows together (joined_mass.h).
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <vector>

#include "dynamics/articulated_factor.h"
#include "kinematics/kernels.h"
#include "kinematics/revolute_kernels.h"
#include "linear/joined_mass.h"
#include "linear/sparse_factor.h"

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
      : model_(model), ws_(ws), added_(added), parent_(speed_parents(model)) {
    if (model.mass_needs_rows) {
      joined_.emplace(parent_, ws.J);
      parent_ = joined_->pattern();
      written_.emplace(parent_);
      return;
    }
    long entries = 0;
    std::vector<long> depth(model.nv, 0);
    for (int k = 0; k < model.nv; ++k) {
      if (parent_[k] >= 0) depth[k] = depth[parent_[k]] + 1;
      entries += depth[k];
    }
    if (entries > longest_written * model.nv) applied_.emplace(model, ws);
    // Of a long chain it holds as many numbers as the square of its length.
    if (!applied_ || model.nv <= most_written) written_.emplace(parent_);
  }

  // Returns -1, or the speed at which M has no inertia. Reads the rows, where M needs them.
  int factorize() {
    current_ = false;
    if (joined_) {
      write(joined_->tree());
      joined_->join(*written_);
      return joined_->factorize(*written_) ? -1 : lightest(joined_->without_inertia());
    }
    if (applied_) return applied_->factorize(added_);
    write(*written_);
    return written_->factorize();
  }
  // Where M needs the rows: f += what stands for J vdot = gamma on the right side (joined_mass.h); by columns, too.
  void add_rows(const double* gamma, double* f, int columns = 1) const {
    if (joined_) joined_->add(gamma, f, columns);
  }
  // Whether M alone has inertia along all speeds, more than rounding. The factors are lost.
  bool definite() {
    current_ = false;
    const int n = model_.nv;
    std::vector<double> left(n);   // of the diagonal, by speed
    std::vector<double> least(n);  // that is more than rounding
    if (applied_) {
      if (applied_->factorize(added_) >= 0) return false;
      for (int k = 0; k < n; ++k) left[k] = applied_->pivot(k);
    } else {
      write(*written_);
      const auto diagonal = [this](int k) { return written_->row(k)[written_->depth(k)]; };
      for (int k = 0; k < n; ++k) least[k] = rounding * diagonal(k);
      if (written_->factorize() >= 0) return false;
      for (int k = 0; k < n; ++k) left[k] = diagonal(k) * diagonal(k);
    }
    const double nothing = JoinedMass::no_inertia * std::ranges::max(left);
    for (int k = 0; k < n; ++k) {
      if (left[k] <= std::max(least[k], nothing)) return false;
    }
    return true;
  }
  void solve_transposed(double* x) const {  // x <- L^-T x: whitens a generalised force
    applied_ ? applied_->solve_transposed(x) : written_->solve_transposed(x);
  }
  // The same for an x with zeros but at these speeds, see inwards().
  void solve_transposed(double* x, const std::vector<int>& speeds) const {
    applied_ ? applied_->solve_transposed(x) : written_->solve_transposed(x, speeds);
  }
  // These speeds and all inwards of them, ascending.
  std::vector<int> inwards(const int* speeds, int count) const {
    std::set<int> out;
    for (const int* speed = speeds; speed != speeds + count; ++speed) {
      for (int k = *speed; k >= 0 && out.insert(k).second; k = parent_[k]) continue;
    }
    return {out.begin(), out.end()};
  }
  void solve(double* x) const {  // x <- L^-1 x: from whitened to speeds
    applied_ ? applied_->solve(x) : written_->solve(x);
  }
  // The same for the columns of x, which is stored row by row; ws still at the position of the factors.
  void solve_transposed(double* x, int columns) const {
    written_down() ? written_->solve_transposed(x, columns) : applied_->solve_transposed(x, columns);
  }
  void solve(double* x, int columns) const {
    written_down() ? written_->solve(x, columns) : applied_->solve(x, columns);
  }
  void multiply(const double* x, double* y) const {  // y = L x: whitens speeds
    applied_ ? applied_->multiply(x, y) : written_->multiply(x, y);
  }

  // M, nv x nv. The factors are lost.
  void matrix(double* M) {
    current_ = false;
    if (!written_) written_.emplace(parent_);
    SparseFactor& plain = joined_ ? joined_->tree() : *written_;
    write(plain);
    const int n = model_.nv;
    std::fill(M, M + static_cast<std::size_t>(n) * n, 0.0);
    for (int i = 0; i < n; ++i) {
      const double* row = plain.row(i);
      const int* column = plain.ancestors(i);
      for (int d = 0; d <= plain.depth(i); ++d) M[i * n + column[d]] = M[column[d] * n + i] = row[d];
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
      write(*written_);
      current_ = written_->factorize() < 0;
    }
    return current_;
  }

  // Of the speeds in a motion the one whose own link has least inertia along it.
  int lightest(const std::vector<double>& motion) const {
    const auto size = [](double x) { return std::abs(x); };
    const double most = std::abs(std::ranges::max(motion, {}, size));
    int best = -1;
    double least = 0;
    for (const auto& link : model_.links) {
      for (int k = link.iv; k < link.iv + link.nv; ++k) {
        if (std::abs(motion[k]) <= 1e-6 * most) continue;
        const double own = kernels::along<A>(link.is_revolute_about_z, ws_.S[k], kernels::times<A>(link.is_revolute_about_z, link.G, ws_.S[k]));
        if (best >= 0 && own >= least) continue;
        best = k;
        least = own;
      }
    }
    return best;
  }

  // Of a pivot in its diagonal: M is a sum of some tens of numbers exact to 2e-16.
  static constexpr double rounding = 1e-14;

  void write(SparseFactor& M) const {
    kernels::mass_matrix(model_, ws_, M);
    for (int k = 0; k < model_.nv; ++k) M.row(k)[M.depth(k)] += added_[k];
  }

  const Model<A>& model_;
  Workspace<A>& ws_;
  const std::vector<double>& added_;
  std::vector<int> parent_;  // of each speed in L: speed_parents(), or that of the tree which the rows ask for
  mutable std::optional<SparseFactor> written_;
  mutable bool current_ = false;  // written_ has what is applied
  std::optional<ArticulatedFactor<A>> applied_;
  std::optional<JoinedMass> joined_;
};

}  // namespace gelenk
