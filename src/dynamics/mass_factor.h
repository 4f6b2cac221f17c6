// SPDX-License-Identifier: BSD-3-Clause
// M = L^T L of a mechanism at the position of the workspace: as a sparse matrix, or, if branches are long, in operator
// form by recursions that are linear in the number of links. If M alone is singular (Mechanism::mass_needs_rows), L is
// the factor of the augmented mass matrix (augmented_mass.h).
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "dynamics/articulated_factor.h"
#include "kinematics/kernels.h"
#include "kinematics/revolute_kernels.h"
#include "linear/augmented_mass.h"
#include "linear/sparse_factor.h"

namespace gelenk {

// parent[k]: the next velocity on the path from k to the ground, -1 at the ground.
template <class A>
std::vector<int> velocity_parents(const Model<A>& model) {
  std::vector<int> parent(model.nv, -1);
  std::vector<int> last(model.links.size(), -1);  // by link: its last velocity, or that of its ancestors
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
  // Throws because M has no inertia at this velocity.
  using Refuse = std::function<void(int velocity)>;

  // model, ws and added must outlive it. added: inertia added to the diagonal of M, by velocity.
  MassFactor(const Model<A>& model, Workspace<A>& ws, const std::vector<double>& added, Refuse refuse)
      : model_(model), ws_(ws), added_inertia_(added), refuse_(std::move(refuse)), parent_(velocity_parents(model)) {
    if (model.mass_needs_rows) {
      augmented_.emplace(parent_, ws.J);
      parent_ = augmented_->pattern();
      sparse_.emplace(parent_);
      return;
    }
    long entries = 0;
    std::vector<long> depth(model.nv, 0);
    for (int k = 0; k < model.nv; ++k) {
      if (parent_[k] >= 0) depth[k] = depth[parent_[k]] + 1;
      entries += depth[k];
    }
    if (entries > max_mean_depth * model.nv) articulated_.emplace(model, ws);
    // For a long chain its size is the square of the length.
    if (!articulated_ || model.nv <= max_explicit_size) sparse_.emplace(parent_);
  }

  // Factorizes M at the position of the workspace. Reads J if the mass matrix is augmented.
  void factorize() const {
    is_postponed_ = false;
    if (const int k = find_factors(); k >= 0) refuse_(k);
  }
  // The same, but not before a factor is needed.
  void postpone() { is_postponed_ = true; }
  void refuse(int velocity) const { refuse_(velocity); }
  // If the mass matrix is augmented: f += J^T S gamma (augmented_mass.h), for each column of f and gamma.
  void add_right_side(const double* gamma, double* f, int columns = 1) const {
    if (augmented_) augmented_->add_right_side(gamma, f, columns);
  }
  // Returns -1, or a velocity at which M alone has no inertia beyond rounding. Invalidates the factors.
  int velocity_without_inertia() {
    sparse_is_current_ = is_postponed_ = false;
    const int n = model_.nv;
    if (n == 0) return -1;
    std::vector<double> pivots(n);                        // of the factorization, by velocity
    std::vector<double> pivot_errors = turned_moments();  // upper bounds of their rounding errors
    for (double& error : pivot_errors) error *= pivot_rounding;
    if (articulated_) {
      if (const int k = articulated_->factorize(added_inertia_); k >= 0) return k;
      for (int k = 0; k < n; ++k) pivots[k] = articulated_->pivot(k);
    } else {
      compute(*sparse_);
      const auto diagonal = [this](int k) { return sparse_->row(k)[sparse_->depth(k)]; };
      for (int k = 0; k < n; ++k) pivot_errors[k] = std::max(pivot_errors[k], pivot_rounding * diagonal(k));
      if (const int k = sparse_->factorize(); k >= 0) return k;
      for (int k = 0; k < n; ++k) pivots[k] = diagonal(k) * diagonal(k);
    }
    const double negligible = AugmentedMass::inertia_threshold * std::ranges::max(pivots);
    for (int k = n - 1; k >= 0; --k) {  // in the order of the factorization: later pivots contain errors of this one
      if (pivots[k] <= std::max(pivot_errors[k], negligible)) return k;
    }
    return -1;
  }
  void solve_transposed(double* x) const {  // x <- L^-T x: whitens a generalized force
    ensure();
    articulated_ ? articulated_->solve_transposed(x) : sparse_->solve_transposed(x);
  }
  // The same for a sparse x. nonzeros: its indices, as from inwards().
  void solve_transposed(double* x, std::span<const int> nonzeros) const {
    ensure();
    articulated_ ? articulated_->solve_transposed(x, nonzeros) : sparse_->solve_transposed(x, nonzeros);
  }
  // The next velocity inwards of k in the pattern of L; -1 at the ground.
  int inward(int k) const { return parent_[static_cast<std::size_t>(k)]; }
  // These velocities and all their ancestors, ascending.
  std::vector<int> inwards(const int* velocities, int count) const {
    std::set<int> out;
    for (const int* first = velocities; first != velocities + count; ++first) {
      for (int k = *first; k >= 0 && out.insert(k).second; k = parent_[k]) continue;
    }
    return {out.begin(), out.end()};
  }
  void solve(double* x) const {  // x <- L^-1 x: from whitened to generalized velocities
    ensure();
    articulated_ ? articulated_->solve(x) : sparse_->solve(x);
  }
  // The same for each column of x (nv x columns), stored row by row; ws must still be at the position of the factors.
  void solve_transposed(double* x, int columns) const {
    ensure_sparse_factor() ? sparse_->solve_transposed(x, columns) : articulated_->solve_transposed(x, columns);
  }
  void solve(double* x, int columns) const {
    ensure_sparse_factor() ? sparse_->solve(x, columns) : articulated_->solve(x, columns);
  }
  void multiply(const double* x, double* y) const {  // y = L x: whitens generalized velocities
    ensure();
    articulated_ ? articulated_->multiply(x, y) : sparse_->multiply(x, y);
  }

  // Computes the full matrix M (nv x nv). Invalidates the factors.
  void matrix(double* M) {
    sparse_is_current_ = is_postponed_ = false;
    if (!sparse_) sparse_.emplace(parent_);
    SparseFactor& plain = augmented_ ? augmented_->M() : *sparse_;
    compute(plain);
    const int n = model_.nv;
    std::fill(M, M + static_cast<std::size_t>(n) * n, 0.0);
    for (int i = 0; i < n; ++i) {
      const double* row = plain.row(i);
      const int* column = plain.ancestors(i);
      for (int d = 0; d <= plain.depth(i); ++d) M[i * n + column[d]] = M[column[d] * n + i] = row[d];
    }
  }

 private:
  // Mean number of velocities inward of one, above which the operator form is faster: measured on chains.
  static constexpr long max_mean_depth = 5;

  // For many columns the sparse factor is faster even then, up to this number of velocities.
  static constexpr int max_explicit_size = 256;

  void ensure() const {
    if (is_postponed_) factorize();
  }
  // By velocity, the sum of the moments about their own centers of mass of all links that it turns. Rounding leaves
  // some of it in the moment about its axis where all of them are about other axes, as those of rotors are.
  std::vector<double> turned_moments() const {
    std::vector<double> out(model_.nv);
    if constexpr (requires(const typename A::Inertia& G) { G.I.trace(); }) {
      std::vector<double> carried(model_.links.size());
      for (std::size_t i = model_.links.size() - 1; i > 0; --i) {
        const auto& link = model_.links[i];
        carried[i] += link.G.I.trace();
        if (link.G.m > 0) carried[i] -= 2 * link.G.h.squaredNorm() / link.G.m;
        carried[link.parent] += carried[i];
        for (int k = link.iv; k < link.iv + link.nv; ++k) out[k] = carried[i] * ws_.S[k].w.squaredNorm();
      }
    }
    return out;
  }
  // Returns -1, or the velocity at which M has no inertia.
  int find_factors() const {
    sparse_is_current_ = false;
    if (augmented_) {
      compute(augmented_->M());
      augmented_->assemble(*sparse_);
      return augmented_->factorize(*sparse_) ? -1 : least_inertia_velocity(augmented_->massless_motion());
    }
    if (articulated_) return articulated_->factorize(added_inertia_);
    compute(*sparse_);
    return sparse_->factorize();
  }
  // Computes the sparse factor, if that is worthwhile. Returns whether it is available.
  bool ensure_sparse_factor() const {
    ensure();
    if (!articulated_) return true;
    if (!sparse_is_current_ && model_.nv <= max_explicit_size) {
      compute(*sparse_);
      sparse_is_current_ = sparse_->factorize() < 0;
    }
    return sparse_is_current_;
  }

  // Among the velocities that take part in a motion, the one with the smallest inertia of its own link.
  int least_inertia_velocity(const std::vector<double>& motion) const {
    const auto size = [](double x) { return std::abs(x); };
    const double max_component = std::abs(std::ranges::max(motion, {}, size));
    int best = -1;
    double least = 0;
    for (const auto& link : model_.links) {
      for (int k = link.iv; k < link.iv + link.nv; ++k) {
        if (std::abs(motion[k]) <= 1e-6 * max_component) continue;
        const double own = kernels::along<A>(link.is_revolute_about_z, ws_.S[k],
                                             kernels::times<A>(link.is_revolute_about_z, link.G, ws_.S[k]));
        if (best >= 0 && own >= least) continue;
        best = k;
        least = own;
      }
    }
    return best;
  }

  // Relative rounding error of a diagonal entry: M is a sum of some tens of numbers exact to 2e-16.
  static constexpr double pivot_rounding = 1e-14;

  void compute(SparseFactor& M) const {
    kernels::mass_matrix(model_, ws_, M);
    for (int k = 0; k < model_.nv; ++k) M.row(k)[M.depth(k)] += added_inertia_[k];
  }

  const Model<A>& model_;
  Workspace<A>& ws_;
  const std::vector<double>& added_inertia_;
  Refuse refuse_;
  std::vector<int> parent_;  // of each velocity in L: velocity_parents(), or the pattern of the augmented matrix
  mutable std::optional<SparseFactor> sparse_;
  mutable bool sparse_is_current_ = false;  // sparse_ has been factorized at the position of articulated_
  mutable std::optional<ArticulatedFactor<A>> articulated_;
  mutable std::optional<AugmentedMass> augmented_;
  mutable bool is_postponed_ = false;
};

}  // namespace gelenk
