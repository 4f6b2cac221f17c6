// SPDX-License-Identifier: BSD-3-Clause
// Implementation of Branching: the modes of the forces along joints, and the coordinates that friction locks.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "dynamics/branching.h"
#include "dynamics/locked_coordinates.h"
#include "kinematics/load_kernels.h"

namespace gelenk {

template <class A>
class JointModes final : public Branching {
 public:
  // The state, as far as modes depend on it. All must outlive it.
  struct State {
    const Model<A>& model;
    const Loads& loads;
    Workspace<A>& ws;
    const std::vector<double>&q, &v, &cut_reference;
  };

  JointModes(const State& state, const MassFactor<A>& M, const MassWeightedJacobian<A>& Y)
      : state_(state), M_(M), locks_(M, Y, state.model.nv, state.model.rows, find_locks()), x_(holders_.size()) {}

  // The modes in which forces are held, or null; of the tree, and from the first cut on.
  const int* held() const { return held_; }
  const int* held_cuts() const { return held_ == nullptr ? nullptr : held_ + state_.loads.tree.branchings(); }
  // Whether coordinates are locked; if so, the locks are those of the held modes, factorized.
  bool locks_any() {
    if (holders_.empty()) return false;
    for (int i = 0; i < locks(); ++i) locks_.lock(i, held_ != nullptr && held_[holders_[i].force] == 0);
    if (locks_.any()) locks_.factorize();
    return locks_.any();
  }
  LockedCoordinates<A>& locked() { return locks_; }
  const LockedCoordinates<A>& locked() const { return locks_; }
  // Records the forces of the locks, in the mechanism's signs.
  void set_holding_forces(const std::vector<double>& x) {
    for (int i = 0; i < locks(); ++i) x_[i] = holders_[i].sign * x[i];
  }

  int count() const override {
    int n = state_.loads.tree.branchings();
    for (const JointLoads& on : state_.loads.cuts) n += on.branchings();
    return n;
  }
  void sides(int* sides) const override {
    each([&](const auto& force, const double* q, const double* v) { *sides++ = force.side(q, v); });
  }
  void indicators(double* g, double* gdot) const override {
    int index = 0;
    int lock = 0;
    each([&](const auto& force, const double* q, const double* v) {
      const double speed = force.sign * v[force.v];
      if constexpr (Sticks<std::decay_t<decltype(force.element)>>) {
        force.element.indicators(held_ == nullptr ? force.side(q, v) : held_[index], speed, x_[lock], g);
        gdot[0] = gdot[1] = NAN;
        ++lock;
      } else {
        force.element.indicators(force.sign * q[force.q], speed, g, gdot);
      }
      ++index;
      g += 2;
      gdot += 2;
    });
  }
  void hold(const int* sides) override { held_ = sides; }

  int locks() const override { return static_cast<int>(holders_.size()); }
  int force_of(int lock) const override { return holders_[lock].force; }
  double sticking_limit(int lock) const override {
    return of_lock(lock, [](const auto& element) { return element.sticking_limit(); });
  }
  double slipping_limit(int lock) const override {
    return of_lock(lock, [](const auto& element) { return element.slipping_limit(); });
  }
  double speed(int lock, const double* v) const override { return holders_[lock].sign * locks_.speed(lock, v); }
  const std::vector<double>& holding_forces() const override { return x_; }
  bool is_redundant() const override { return locks_.rank() < locks_.locked_count(); }

  void compliance(const std::vector<int>& locks, Eigen::MatrixXd& W) override {
    const auto size = static_cast<Eigen::Index>(locks.size());
    Eigen::MatrixXd y(state_.model.nv, size);
    Eigen::MatrixXd z(state_.model.nv, size);
    for (Eigen::Index i = 0; i < size; ++i) {
      locks_.whiten(locks[i], y.col(i).data());
      locks_.permitted_part(y.col(i).data(), z.col(i).data());
      if (z.col(i).norm() <= LockedCoordinates<A>::rank_threshold * y.col(i).norm()) z.col(i).setZero();
      z.col(i) *= holders_[locks[i]].sign;
    }
    W = z.transpose() * z;
  }

  void stop(double* v) override {
    if (!locks_any()) return;
    std::vector<double>& w = work_;
    w.resize(static_cast<std::size_t>(state_.model.nv));
    M_.multiply(v, w.data());
    locks_.stop(w.data());
    M_.solve(w.data());
    std::ranges::copy(w, v);
    locks_.clear(v);
  }

 private:
  // A force that can lock its coordinate.
  struct Holder {
    int force;
    double sign;  // user's speed = sign * mechanism's
  };

  // Calls visit(force, q, v) for all forces with modes, with the coordinates and velocities to which they refer.
  template <class Visit>
  void each(Visit visit) const {
    state_.loads.tree.each_branching([&](const auto& force) { visit(force, state_.q.data(), state_.v.data()); });
    for (int c = 0; c < static_cast<int>(state_.loads.cuts.size()); ++c) {
      if (!state_.loads.cuts[c].has_branches()) continue;
      const auto [q, v] = kernels::counted_cut_motion(state_.model, state_.ws, c, state_.cut_reference.data());
      state_.loads.cuts[c].each_branching([&](const auto& force) { visit(force, q.data(), v.data()); });
    }
  }

  template <class Of>
  double of_lock(int lock, Of of) const {
    double out = 0;
    int index = 0;
    const auto look = [&](const auto& force) {
      if constexpr (Sticks<std::decay_t<decltype(force.element)>>) {
        if (index++ == lock) out = of(force.element);
      }
    };
    state_.loads.tree.each_branching(look);
    for (const JointLoads& on : state_.loads.cuts) on.each_branching(look);
    return out;
  }

  // The rows of all locks; fills holders_.
  std::vector<typename LockedCoordinates<A>::Row> find_locks() {
    std::vector<typename LockedCoordinates<A>::Row> rows;
    int index = 0;
    int cut = -1;
    const auto look = [&](const auto& force) {
      if constexpr (Sticks<std::decay_t<decltype(force.element)>>) {
        holders_.push_back({index, force.sign});
        if (cut < 0) {
          rows.push_back({{force.v, 1}});
        } else {
          rows.push_back(rotation_row(cut));
        }
      }
      ++index;
    };
    state_.loads.tree.each_branching(look);
    for (cut = 0; cut < static_cast<int>(state_.loads.cuts.size()); ++cut) state_.loads.cuts[cut].each_branching(look);
    return rows;
  }

  // In the plane, the angle of a cut revolute joint is a sum of angles of tree joints (mechanism/tree.cpp cuts no other
  // joint with friction).
  typename LockedCoordinates<A>::Row rotation_row(int cut) const {
    typename LockedCoordinates<A>::Row out;
    if constexpr (A::planar) {
      const std::vector<double> q(static_cast<std::size_t>(state_.model.nq));
      kernels::positions(state_.model, q.data(), state_.ws);  // the angular parts of S are the same at all positions
      const auto add_path = [&](const std::vector<int>& links, double sign) {
        for (const int i : links) {
          const auto& link = state_.model.links[i];
          for (int k = link.iv; k < link.iv + link.nv; ++k) {
            if (state_.ws.S[k].w != 0) out.push_back({k, sign * state_.ws.S[k].w});
          }
        }
      };
      add_path(state_.model.cuts[cut].path_b, 1);
      add_path(state_.model.cuts[cut].path_a, -1);
    }
    return out;
  }

  State state_;
  const MassFactor<A>& M_;
  const int* held_ = nullptr;
  std::vector<Holder> holders_;  // by lock
  LockedCoordinates<A> locks_;
  std::vector<double> x_;  // forces of the last solve(), user's signs
  std::vector<double> work_;
};

}  // namespace gelenk
