// SPDX-License-Identifier: BSD-3-Clause
// The implementation of ContactRows on the workspace of the kernels. Rows are sparse: those of a body that only
// contacts connect to others have six entries.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "dynamics/contact_rows.h"
#include "dynamics/locked_coordinates.h"
#include "dynamics/mass_factor.h"
#include "dynamics/mass_weighted_jacobian.h"

namespace gelenk {

template <class A>
class ContactRowsOf final : public ContactRows {
 public:
  // All must outlive it.
  ContactRowsOf(const Model<A>& model, const Workspace<A>& ws, const MassFactor<A>& M, const MassWeightedJacobian<A>& Y,
                const LockedCoordinates<A>& locks)
      : model_(model),
        ws_(ws),
        M_(M),
        Y_(Y),
        locks_(locks),
        work_(static_cast<std::size_t>(model.nv)),
        zero_(static_cast<std::size_t>(model.rows)),
        marks_(static_cast<std::size_t>(model.nv), 0) {}

  void reserve(int rows) override {
    const auto n = static_cast<std::size_t>(rows);
    for (std::vector<int>* of : {&first_, &whitened_first_}) of->reserve(n + 1);
    // A row has at most all velocities; in large mechanisms it has few of them.
    constexpr std::size_t enough = std::size_t{1} << 16;
    const std::size_t most = std::min(n * work_.size(), enough);
    for (std::vector<int>* of : {&columns_, &whitened_columns_}) of->reserve(most);
    for (std::vector<double>* of : {&values_, &whitened_}) of->reserve(most);
  }

  void clear() override {
    first_.assign(1, 0);
    whitened_first_.assign(1, 0);
    columns_.clear();
    values_.clear();
    whitened_columns_.clear();
    whitened_.clear();
  }

  void add(int link_a, int link_b, const Eigen::Vector3d& p, const Eigen::Vector3d& d, bool turns) override {
    each_entry(link_a, link_b, p, d, turns, [&](int column, double value) { push(column, value); });
    finish_row();
  }

  void row(int link_a, int link_b, const Eigen::Vector3d& p, const Eigen::Vector3d& d, bool turns,
           double* out) const override {
    std::fill_n(out, model_.nv, 0.0);
    each_entry(link_a, link_b, p, d, turns, [&](int column, double value) { out[column] += value; });
  }

  void add_lock(int lock, double factor) override {
    for (const auto& term : locks_.row(lock)) push(term.v, factor * term.factor);
    finish_row();
  }

  int count() const override { return static_cast<int>(first_.size()) - 1; }

  void speeds(const double* v, double* out) const override {
    for (int r = 0; r < count(); ++r) {
      out[r] = 0;
      for (int k = first_[r]; k < first_[r + 1]; ++k) out[r] += values_[k] * v[columns_[k]];
    }
  }

  void apply(const double* x, double* out) const override {
    combine(x);
    for (int r = 0; r < count(); ++r) {
      out[r] = 0;
      for (int k = whitened_first_[r]; k < whitened_first_[r + 1]; ++k)
        out[r] += whitened_[k] * work_[whitened_columns_[k]];
    }
  }

  WhitenedRows whitened() const override {
    if (model_.rows > 0) return {};
    return {model_.nv, whitened_first_, whitened_columns_, whitened_};
  }

  void block(int first, int size, double* out) const override {
    for (int i = 0; i < size; ++i) {
      for (int j = 0; j < size; ++j) out[i * size + j] = dot(first + i, first + j);
    }
  }

  void add_generalized(int first, const double* x, double factor, double* out) const override {
    for (int r = first; r < count(); ++r) {
      for (int k = first_[r]; k < first_[r + 1]; ++k) out[columns_[k]] += factor * x[r] * values_[k];
    }
  }

  void strike(const double* x, double* v) const override {
    combine(x);
    M_.solve(work_.data());
    for (std::size_t k = 0; k < work_.size(); ++k) v[k] += work_[k];
  }

  void apply_forces(const Spatial::Force* wrenches, const double* along) override {
    wrenches_ = wrenches;
    along_ = along;
  }
  bool has_wrenches() const { return wrenches_ != nullptr; }
  bool has_forces() const { return wrenches_ != nullptr || along_ != nullptr; }
  // Adds the applied wrenches to the loads of the links.
  void add_wrenches(Workspace<A>& ws) const {
    if constexpr (!A::planar) {
      if (wrenches_ == nullptr) return;
      for (std::size_t i = 1; i < model_.links.size(); ++i) {
        if (wrenches_[i].f.isZero(0) && wrenches_[i].n.isZero(0)) continue;
        ws.F_ext[i] += ws.X_0L[i].to_child(wrenches_[i]);
      }
    }
  }
  // Adds the applied generalized forces to f.
  void add_along(double* f) const {
    if (along_ == nullptr) return;
    for (int k = 0; k < model_.nv; ++k) f[k] += along_[k];
  }

 private:
  void push(int column, double value) {
    columns_.push_back(column);
    values_.push_back(value);
  }

  // Calls visit(velocity, entry) for the entries of a row.
  template <class Visit>
  void each_entry(int link_a, int link_b, const Eigen::Vector3d& p, const Eigen::Vector3d& d, bool turns,
                  const Visit& visit) const {
    if constexpr (!A::planar) {
      const typename A::Force F_0 =
          turns ? typename A::Force{d, Eigen::Vector3d::Zero()} : typename A::Force{p.cross(d), d};
      // Links are numbered depth first: the one with the larger number is never an ancestor of the other.
      int a = link_a;
      int b = link_b;
      while (a != b) {
        int& outer = a > b ? a : b;
        each_entry_of_link(outer, a > b ? -1 : 1, F_0, visit);
        outer = model_.links[outer].parent;
      }
    }
  }

  template <class Visit>
  void each_entry_of_link(int i, double sign, const typename A::Force& F_0, const Visit& visit) const {
    const auto& link = model_.links[i];
    if (link.nv == 0) return;
    const typename A::Force F_L = ws_.X_0L[i].to_child(F_0);
    for (int k = link.iv; k < link.iv + link.nv; ++k) {
      visit(k, sign * (ws_.S[k].w.dot(F_L.n) + ws_.S[k].v.dot(F_L.f)));
    }
  }

  // Whitens the row that ends the list.
  void finish_row() {
    const int begin = first_.back();
    const int end = static_cast<int>(columns_.size());
    first_.push_back(end);
    // The nonzeros of the whitened row: the velocities of the row and all inwards of them, ascending.
    const auto pattern_begin = static_cast<std::ptrdiff_t>(whitened_columns_.size());
    for (int k = begin; k < end; ++k) {
      for (int column = columns_[k]; column >= 0 && !is_marked(column); column = M_.inward(column)) mark(column);
    }
    std::sort(whitened_columns_.begin() + pattern_begin, whitened_columns_.end());
    ++stamp_;
    const auto nonzeros = std::span<const int>(whitened_columns_).subspan(static_cast<std::size_t>(pattern_begin));
    for (const int k : nonzeros) work_[k] = 0;
    for (int k = begin; k < end; ++k) work_[columns_[k]] += values_[k];
    M_.solve_transposed(work_.data(), nonzeros);
    for (const int k : nonzeros) whitened_.push_back(work_[k]);
    whitened_first_.push_back(static_cast<int>(whitened_columns_.size()));
  }
  bool is_marked(int column) const { return marks_[column] == stamp_; }
  void mark(int column) {
    marks_[column] = stamp_;
    whitened_columns_.push_back(column);
  }

  // work_ <- P Y x.
  void combine(const double* x) const {
    std::ranges::fill(work_, 0.0);
    for (int r = 0; r < count(); ++r) {
      if (x[r] == 0) continue;
      for (int k = whitened_first_[r]; k < whitened_first_[r + 1]; ++k)
        work_[whitened_columns_[k]] += x[r] * whitened_[k];
    }
    if (model_.rows > 0) Y_.solve_constrained(work_.data(), zero_.data(), nullptr);
  }

  // The scalar product of two whitened rows, whose columns ascend.
  double dot(int r, int s) const {
    double sum = 0;
    int k = whitened_first_[r];
    int l = whitened_first_[s];
    while (k < whitened_first_[r + 1] && l < whitened_first_[s + 1]) {
      const int difference = whitened_columns_[k] - whitened_columns_[l];
      if (difference == 0) sum += whitened_[k] * whitened_[l];
      k += difference <= 0 ? 1 : 0;
      l += difference >= 0 ? 1 : 0;
    }
    return sum;
  }

  const Model<A>& model_;
  const Workspace<A>& ws_;
  const MassFactor<A>& M_;
  const MassWeightedJacobian<A>& Y_;
  const LockedCoordinates<A>& locks_;
  const Spatial::Force* wrenches_ = nullptr;
  const double* along_ = nullptr;
  std::vector<int> first_{0}, columns_;  // of each row
  std::vector<double> values_;
  std::vector<int> whitened_first_{0}, whitened_columns_;
  std::vector<double> whitened_;
  mutable std::vector<double> work_;
  std::vector<double> zero_;
  std::vector<long> marks_;  // by velocity: the stamp of the row that has it
  long stamp_ = 1;
};

}  // namespace gelenk
