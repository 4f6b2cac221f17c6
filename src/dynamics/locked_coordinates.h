// SPDX-License-Identifier: BSD-3-Clause
// Coordinates that friction and limits keep at rest. A locked coordinate s adds the constraint equation S v = 0 with a
// constant row S, and its force x to the equations of motion,
//   M vdot + J^T lambda = f + S^T x,   J vdot = gamma,   S vdot = 0.
// The factors of the equations without locks remain in use: with y = L^-T S^T, M = L^T L, and z = its part that the
// constraint equations J permit, locks demand z^T w = z^T w0 - y^T w0 of w = L vdot, where w0 solves the equations
// without them. Several locks may be redundant with each other and with J; then x is of minimum norm.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "dynamics/articulated_factor.h"
#include "dynamics/mass_factor.h"
#include "dynamics/mass_weighted_jacobian.h"
#include "linear/row_factor.h"

namespace gelenk {

template <class A>
class LockedCoordinates {
 public:
  // A constant row: speed of the coordinate = sum of factor times velocity.
  struct Term {
    int v;
    double factor;
  };
  using Row = std::vector<Term>;

  // All but rows must outlive it. added_inertia: on the diagonal of M. rows: of all coordinates that can be locked.
  // rank_threshold: a row whose permitted part is below this fraction of it is determined by other constraints.
  LockedCoordinates(const Model<A>& model, const Workspace<A>& ws, const std::vector<double>& added_inertia,
                    const MassFactor<A>& M, const MassWeightedJacobian<A>& Y, std::vector<Row> rows,
                    double rank_threshold)
      : M_(M),
        Y_(Y),
        added_inertia_(added_inertia),
        n_(model.nv),
        rank_threshold_(rank_threshold),
        rows_(std::move(rows)),
        locked_(rows_.size(), 0),
        y_(rows_.size(), std::vector<double>(static_cast<std::size_t>(n_))),
        inverse_size_(rows_.size()),
        inverse_mobility_(rows_.size(), INFINITY),
        mobility_is_current_(rows_.size(), 0),
        zero_(static_cast<std::size_t>(model.rows)),
        gap_(rows_.size()),
        w_(static_cast<std::size_t>(n_)),
        column_(static_cast<std::size_t>(n_)),
        factor_(n_, static_cast<int>(rows_.size())) {
    held_.reserve(rows_.size());
    // A cut joint of which all constraint equations are redundant still has a coordinate, of several tree joints.
    const auto is_of_tree = [](const Row& row) { return row.size() == 1 && row.front().factor == 1; };
    if (model.rows == 0 && !rows_.empty() && std::ranges::all_of(rows_, is_of_tree) && !any_twice()) {
      tree_.emplace(model, ws);
      held_velocities_.assign(static_cast<std::size_t>(n_), 0);
    }
    for (const Row& row : rows_) {
      std::vector<int> velocities;
      for (const Term& term : row) velocities.push_back(term.v);
      pattern_.push_back(M.inwards(velocities.data(), static_cast<int>(velocities.size())));
    }
  }

  int count() const { return static_cast<int>(rows_.size()); }
  const Row& row(int i) const { return rows_[static_cast<std::size_t>(i)]; }
  bool any() const { return locked_count_ > 0; }
  // Changes when M and Y do.
  long generation() const { return generation_; }
  // Whether accelerations leave locked coordinates out: in a tree without constraint equations.
  bool is_tree() const { return tree_.has_value(); }
  bool is_locked(int i) const { return locked_[i] != 0; }
  // Whether some locks would have no effect of their own beside the others and the constraint equations.
  bool are_redundant() const { return !tree_ && factor_.rank() < locked_count_; }

  // Force per |L^-T f| that has the same effect on a locked coordinate; infinite if other constraints determine it.
  // unhindered: as if there were no constraint equations.
  double inverse_mobility(int i, bool unhindered = false) const {
    if (unhindered) {
      whiten(i, column_.data());
      return 1 / norm(column_.data());
    }
    if (tree_ && locked_[i] != 0 && mobility_is_current_[i] == 0) {
      whiten(i, y_[i].data());
      inverse_mobility_[i] = 1 / norm(y_[i].data());
      mobility_is_current_[i] = 1;
    }
    return inverse_mobility_[i];
  }

  // Locks coordinate i or releases it.
  void lock(int i, bool on) {
    if ((locked_[i] != 0) == on) return;
    locked_[i] = on ? 1 : 0;
    locked_count_ += on ? 1 : -1;
    if (tree_) held_velocities_[rows_[i].front().v] = locked_[i];
    locks_changed();
  }
  // Call after M and Y have been factorized again.
  void factors_changed() {
    ++generation_;
    locks_changed();
    std::ranges::fill(mobility_is_current_, 0);
  }
  // f <- the accelerations that generalized forces f cause in a tree without constraint equations, and x <- the forces
  // (0 where not locked) that stop the locked coordinates. Returns false, and does nothing, in other mechanisms. As
  // MassFactor, refuses motion without inertia.
  bool solve_tree(double* f, double* x) {
    if (!tree_) return false;
    if (!tree_is_current_) {
      if (const int k = tree_->factorize(added_inertia_, held_velocities_); k >= 0) M_.refuse(k);
      tree_is_current_ = true;
    }
    tree_->solve_held(held_velocities_, f);
    for (int i = 0; i < count(); ++i) {
      double& vdot = f[rows_[i].front().v];
      x[i] = locked_[i] != 0 ? std::exchange(vdot, 0.0) : 0;
    }
    return true;
  }
  // The same, without x, for each column of f (n x columns), stored row by row.
  bool solve_tree(double* f, int columns) {
    if (!tree_) return false;
    for (int j = 0; j < columns; ++j) {
      for (int k = 0; k < n_; ++k) column_[k] = f[k * columns + j];
      solve_tree(column_.data(), gap_.data());
      for (int k = 0; k < n_; ++k) f[k * columns + j] = column_[k];
    }
    return true;
  }
  // Factorizes the locked rows with the present factors of M and Y.
  void factorize() {
    if (is_current_) return;
    is_current_ = true;
    fill_rows();
    factor_.factorize(locked_count_);
  }

  // w <- w changed by the least amount that stops the locked coordinates; it satisfies the constraint equations.
  void stop(double* w) {
    factorize();
    find_gaps(w);
    find_stop();
    for (int k = 0; k < n_; ++k) w[k] += w_[k];
  }
  // The same of coordinates that are at rest within rounding. At a dead center their rows have hardly any part along
  // the motion, and what stops a speed of 1e-12 there would stop the mechanism: along such directions the motion is
  // kept, unless rounding explains its change, or it is so slow that friction with so small a lever may hold it.
  // Returns whether all are stopped.
  bool stop_rounding(double* w) {
    factorize();
    find_gaps(w);
    find_stop();
    const int strong = factor_.pivots_above(weak_part);
    const bool stops_all = strong == factor_.rank() || may_stop_all(strong, w);
    for (int k = 0; k < n_; ++k) w[k] += w_[k];
    return stops_all;
  }
  // The same for each column of w (n x columns), stored row by row.
  void stop(double* w, int columns) {
    for (int j = 0; j < columns; ++j) {
      for (int k = 0; k < n_; ++k) column_[k] = w[k * columns + j];
      stop(column_.data());
      for (int k = 0; k < n_; ++k) w[k * columns + j] = column_[k];
    }
  }
  // x: the forces (0 where not locked) that stop them; w solves the equations without locks.
  void forces(const double* w, double* x) {
    factorize();
    find_gaps(w);
    find_stop();
    factor_.multipliers(gap_.data());
    std::fill_n(x, count(), 0.0);
    for (std::size_t k = 0; k < held_.size(); ++k) x[held_[k]] = -gap_[k] * inverse_size_[held_[k]];
  }
  // Adds S^T x to the generalized forces f.
  void add_forces(const double* x, double* f) const {
    for (int i = 0; i < count(); ++i) {
      if (locked_[i] == 0) continue;
      for (const Term& term : rows_[i]) f[term.v] += term.factor * x[i];
    }
  }
  // Adds to lambda the multipliers of constraint equations that balance the forces x of the locks.
  void add_multipliers(const double* x, double* lambda) const {
    if (zero_.empty()) return;
    std::fill(w_.begin(), w_.end(), 0.0);
    add_forces(x, w_.data());
    M_.solve_transposed(w_.data());
    Y_.solve_constrained(w_.data(), zero_.data(), nullptr);
    std::vector<double> balancing(zero_.size());
    Y_.multipliers(balancing.data());
    for (std::size_t r = 0; r < balancing.size(); ++r) lambda[r] += balancing[r];
  }
  // Sets the velocities or accelerations of locked tree coordinates to exactly 0, which they are within rounding.
  void clear(double* v) const {
    for (int i = 0; i < count(); ++i) {
      if (locked_[i] != 0 && rows_[i].size() == 1) v[rows_[i].front().v] = 0;
    }
  }
  // The same for each column of v (n x columns), stored row by row.
  void clear(double* v, int columns) const {
    for (int i = 0; i < count(); ++i) {
      if (locked_[i] != 0 && rows_[i].size() == 1) std::fill_n(v + rows_[i].front().v * columns, columns, 0.0);
    }
  }
  // The speed (acceleration) of coordinate i for these velocities (accelerations).
  double speed(int i, const double* v) const {
    double sum = 0;
    for (const Term& term : rows_[i]) sum += term.factor * v[term.v];
    return sum;
  }
  // out <- L^-T of the row, and the part of y that the constraint equations permit.
  void whiten(int i, double* out) const {
    std::fill(out, out + n_, 0.0);
    for (const Term& term : rows_[i]) out[term.v] += term.factor;
    M_.solve_transposed(out, pattern_[i]);
  }
  // Returns the size of that part; 0, as the part, if other constraints determine the coordinate.
  double permitted_part(const double* y, double* z) const {
    std::copy(y, y + n_, z);
    if (!zero_.empty()) Y_.solve_constrained(z, zero_.data(), nullptr);
    const double permitted = norm(z);
    if (permitted > rank_threshold_ * norm(y)) return permitted;
    std::fill(z, z + n_, 0.0);
    return 0;
  }

 private:
  // Part of a row, below which it hardly determines the motion. The change that rounding explains, relative to the
  // motion or to one with a speed of 1, and what is as good as at rest, relative to the latter.
  static constexpr double weak_part = 1e-3;
  static constexpr double explained_fraction = 1e-10;
  static constexpr double slow_fraction = 1e-6;

  void fill_rows() {
    held_.clear();
    for (int i = 0; i < count(); ++i) {
      if (locked_[i] == 0) continue;
      double* z = factor_.column(static_cast<int>(held_.size()));
      held_.push_back(i);
      whiten(i, y_[i].data());
      const double size = norm(y_[i].data());
      inverse_size_[i] = 1 / size;
      const double permitted = permitted_part(y_[i].data(), z);
      inverse_mobility_[i] = permitted > 0 ? size / (permitted * permitted) : INFINITY;
      for (int k = 0; k < n_; ++k) z[k] *= inverse_size_[i];
    }
    factor_.set_rows(locked_count_);
  }
  // w_ <- the least change by which the gaps vanish.
  void find_stop() {
    std::fill(w_.begin(), w_.end(), 0.0);
    factor_.solve_constrained(w_.data(), gap_.data(), nullptr);
  }
  // Whether the change w_ of w may go beyond that in the first `rank` directions; if not, w_ becomes the latter.
  bool may_stop_all(int rank, const double* w) {
    double unit = 0;
    for (const int i : held_) unit = std::max(unit, inverse_size_[i]);
    const double size = norm(w);
    if (size <= slow_fraction * unit) return true;
    column_ = w_;
    fill_rows();
    factor_.factorize(rank);
    is_current_ = false;
    find_stop();
    double beyond = 0;
    for (int k = 0; k < n_; ++k) beyond = std::hypot(beyond, column_[k] - w_[k]);
    const bool is_explained = beyond <= explained_fraction * std::max(size, unit);
    if (is_explained) w_ = column_;
    return is_explained;
  }
  void locks_changed() { is_current_ = tree_is_current_ = false; }
  // Whether two locks hold the same coordinate of the tree.
  bool any_twice() const {
    std::vector<int> velocities;
    for (const Row& row : rows_) velocities.push_back(row.front().v);
    std::ranges::sort(velocities);
    return std::ranges::adjacent_find(velocities) != velocities.end();
  }
  double norm(const double* x) const { return std::sqrt(dot(x, x)); }
  double dot(const double* x, const double* y) const {
    double sum = 0;
    for (int k = 0; k < n_; ++k) sum += x[k] * y[k];
    return sum;
  }
  void find_gaps(const double* w) const {
    for (std::size_t k = 0; k < held_.size(); ++k) gap_[k] = -dot(y_[held_[k]].data(), w) * inverse_size_[held_[k]];
  }

  const MassFactor<A>& M_;
  const MassWeightedJacobian<A>& Y_;
  const std::vector<double>& added_inertia_;
  int n_;
  double rank_threshold_;
  std::vector<Row> rows_;
  std::vector<std::vector<int>> pattern_;  // by lock: the nonzeros of its whitened row, ascending
  std::vector<char> locked_;
  int locked_count_ = 0;
  long generation_ = 0;
  bool is_current_ = false;  // factor_
  std::vector<int> held_;    // the locked coordinates, by row of the factor
  mutable std::vector<std::vector<double>> y_;
  std::vector<double> inverse_size_;  // 1 / |y|
  mutable std::vector<double> inverse_mobility_;
  mutable std::vector<char> mobility_is_current_;  // in a tree, where it is found when asked for
  std::vector<double> zero_;
  mutable std::vector<double> gap_, w_, column_;  // gap_: by row of the factor
  RowFactor factor_;                              // of z / |y|
  std::optional<ArticulatedFactor<A>> tree_;      // without constraint equations: of what is not locked
  std::vector<char> held_velocities_;             // by velocity: locked
  bool tree_is_current_ = false;
};

}  // namespace gelenk
