// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/gauss_seidel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "complementarity/block_solver.h"

namespace gelenk {
namespace {

using Eigen::Index;

constexpr int plain_sweeps = 10;  // at the start: the active contacts change
constexpr int stall = 20;         // sweeps without gain, after which some follow with momentum
constexpr int momentum_sweeps = 100;
constexpr double max_change_growth = 2;  // of the change by a sweep, beyond which the acceleration starts again
constexpr Index sampled_size = 300;      // unknowns, beyond which residuals are looked at once in an sampling_interval
constexpr int sampling_interval = 5;     // sweeps; they count as one iteration then
constexpr int sweeps_between_renewals =
    20;  // sweeps without acceleration between evaluations of G x: updates add rounding

std::size_t index(Index i) { return static_cast<std::size_t>(i); }

// u = G x + b itself, by the columns of G.
class DenseVelocities {
 public:
  explicit DenseVelocities(ConeIteration& at) : at_(at), G_(at.matrix()) {}

  double u(Index row) const { return at_.u()[row]; }
  void change(Index column, double by) {
    const double factor = at_.scale(column) * by;
    for (Index i = 0; i < at_.size(); ++i) at_.u()[i] += at_.scale(i) * G_(i, column) * factor;
  }
  void renew() { at_.update_velocity(); }
  void set_all() const {}

 private:
  ConeIteration& at_;
  Eigen::Map<const Eigen::MatrixXd> G_;
};

// The whitened velocities w = W x, of which a cone changes those of its two bodies.
class WhitenedVelocities {
 public:
  WhitenedVelocities(ConeIteration& at, std::vector<double>& value, std::vector<double>& w)
      : at_(at), W_(at.G().root()), value_(value), w_(w) {
    value_.assign(W_.value.begin(), W_.value.end());
    for (Index j = 0; j < at.size(); ++j) {
      for (std::size_t k = begin(j); k < end(j); ++k) value_[k] *= at.scale(j);
    }
    renew();
  }

  double u(Index row) const {
    double sum = at_.b()[row];
    for (std::size_t k = begin(row); k < end(row); ++k) sum += value_[k] * w_[place(k)];
    return sum;
  }
  void change(Index column, double by) {
    for (std::size_t k = begin(column); k < end(column); ++k) w_[place(k)] += value_[k] * by;
  }
  void renew() {
    w_.assign(static_cast<std::size_t>(W_.rows), 0.0);
    for (Index j = 0; j < at_.size(); ++j) {
      if (at_.x()[j] != 0) change(j, at_.x()[j]);
    }
  }
  void set_all() const {
    for (Index j = 0; j < at_.size(); ++j) at_.u()[j] = u(j);
  }

 private:
  std::size_t begin(Index j) const { return index(W_.first[index(j)]); }
  std::size_t end(Index j) const { return index(W_.first[index(j) + 1]); }
  std::size_t place(std::size_t k) const { return index(W_.row[k]); }

  ConeIteration& at_;
  ConeRoot W_;
  std::vector<double>& value_;
  std::vector<double>& w_;
};

// x of one cone. block: its rows and columns of G.
template <class Velocities>
void relax(ConeIteration& at, const Cone& cone, const double* block, Velocities& velocities) {
  if (cone.interval && cone.lower == cone.upper && at.x()[cone.first] == cone.lower) return;
  const auto n = index(cone.size());
  std::array<double, Cone::max_size> q{}, x{};
  bool separate = !cone.interval && !cone.is_ball;
  for (std::size_t i = 0; i < n; ++i) {
    const Index row = cone.first + static_cast<Index>(i);
    x[i] = at.x()[row];
    q[i] = velocities.u(row);
    separate = separate && x[i] == 0 && q[0] >= 0;
    if (separate && at.exact()) return;
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) q[i] -= block[i * n + j] * x[j];
  }
  solve_block(cone, block, q.data(), at.exact(), x.data());
  for (std::size_t i = 0; i < n; ++i) {
    const Index row = cone.first + static_cast<Index>(i);
    const double change = x[i] - at.x()[row];
    if (change == 0) continue;
    at.x()[row] = x[i];
    velocities.change(row, change);
  }
}

}  // namespace

void GaussSeidel::reserve(Index n, std::size_t cones) {
  memory_.start(2 * n);
  before_ = memory_.take(n);
  last_ = memory_.take(n);
  acceleration_.start(n);
  if (blocks_.size() < cones) blocks_.resize(cones);
}

void GaussSeidel::take_blocks(ConeIteration& at) {
  const std::span<const Cone> cones = at.cones();
  for (std::size_t k = 0; k < cones.size(); ++k) {
    at.G().diagonal_block(cones[k], blocks_[k].data());
    const int n = cones[k].size();
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        blocks_[k][index(i * n + j)] *= at.scale(cones[k].first + i) * at.scale(cones[k].first + j);
      }
    }
  }
}

template <class Velocities>
void GaussSeidel::sweep(ConeIteration& at, Velocities& velocities) {
  const std::span<const Cone> cones = at.cones();
  for (std::size_t k = 0; k < cones.size(); ++k) relax(at, cones[k], blocks_[k].data(), velocities);
  at.count_product();
}

void GaussSeidel::start_momentum(ConeIteration& at) {
  momentum_ = 1;
  ConeVector(last_, at.size()) = at.x();
}

// After a sweep. The momentum starts again where it points back.
void GaussSeidel::add_momentum(ConeIteration& at) {
  const double next = (1 + std::sqrt(1 + 4 * momentum_ * momentum_)) / 2;
  ConeVector before(before_, at.size()), last(last_, at.size());
  const bool back = (at.x() - before).dot(at.x() - last) < 0;
  const double part = back ? 0 : (momentum_ - 1) / next;
  momentum_ = back ? 1 : next;
  before = at.x();
  at.x() += part * (at.x() - last);
  last = before;
}

void GaussSeidel::start_acceleration(ConeIteration& at) {
  acceleration_.start(at.size());
  last_change_ = std::numeric_limits<double>::infinity();
}

// After a sweep. Returns false, and starts again, if sweeps no longer contract.
bool GaussSeidel::accelerate(ConeIteration& at) {
  const ConeVector before(before_, at.size());
  const double change = (at.x() - before).norm();
  if (change > max_change_growth * last_change_) {
    start_acceleration(at);
    return false;
  }
  last_change_ = change;
  at.x() = acceleration_.next(before, at.x());
  return true;
}

template <class Velocities>
void GaussSeidel::sweep_all(ConeIteration& at, Velocities& velocities, int max_sweeps, int patience) {
  double least = at.best_residual();
  int least_at = 0, momentum_until = 0;
  start_acceleration(at);
  for (int k = 1; k <= max_sweeps && k - least_at <= patience; ++k) {
    ConeVector(before_, at.size()) = at.x();
    sweep(at, velocities);
    if (at.size() <= sampled_size || k % sampling_interval == 0) {
      velocities.set_all();
      if (!at.advance()) return;
      if (at.best_residual() < least / 2) {
        least = at.best_residual();
        least_at = k;
      }
    }
    if (k >= plain_sweeps && k - std::max(least_at, momentum_until) >= stall) {
      momentum_until = k + momentum_sweeps;
      start_momentum(at);
      start_acceleration(at);
    }
    bool renewed = k % sweeps_between_renewals == 0;
    if (k < momentum_until) {
      add_momentum(at);
      renewed = true;
    } else if (k >= plain_sweeps) {
      renewed = accelerate(at) || renewed;
    }
    if (renewed) velocities.renew();
  }
  velocities.renew();
  velocities.set_all();
}

void GaussSeidel::run(ConeIteration& at, int max_sweeps, int patience) {
  reserve(at.size(), at.cones().size());
  take_blocks(at);
  if (at.G().dense() == nullptr && !at.G().root().first.empty()) {
    WhitenedVelocities velocities(at, value_, w_);
    sweep_all(at, velocities, max_sweeps, patience);
  } else {
    DenseVelocities velocities(at);
    sweep_all(at, velocities, max_sweeps, patience);
  }
}

namespace {

class GaussSeidelSolver final : public IterativeConeSolver {
  void reserve(ConeIteration& at) override { method_.reserve(at.size(), at.cones().size()); }
  void run(ConeIteration& at) override {
    constexpr int all = std::numeric_limits<int>::max();
    method_.run(at, all, all);
  }
  GaussSeidel method_;
};

}  // namespace

std::unique_ptr<ConeSolver> make_gauss_seidel_cone_solver() { return std::make_unique<GaussSeidelSolver>(); }

}  // namespace gelenk
