// SPDX-License-Identifier: BSD-3-Clause
#include "complementarity/iteration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "complementarity/projection.h"

namespace gelenk {
namespace {

using Eigen::Index;

constexpr double epsilon = std::numeric_limits<double>::epsilon();

bool all_finite(const double* x, Index n) {
  return std::all_of(x, x + n, [](double value) { return std::isfinite(value); });
}

bool valid(const Cone& cone) {
  if (cone.interval) return cone.size() == 1 && cone.lower <= cone.upper;
  if (cone.is_ball) {
    const bool has_size = cone.tangential >= 1 && cone.tangential <= 3 && cone.size() == cone.tangential;
    return has_size && cone.radius >= 0 && std::isfinite(cone.radius);
  }
  for (const ConeGroup& group : cone.limited()) {
    if (group.size < 0 || !(group.coefficient >= 0) || !std::isfinite(group.coefficient)) return false;
  }
  return cone.tangential <= 2 && cone.spin <= 1 && cone.roll <= 2;
}

}  // namespace

void ConeMemory::start(Index numbers) {
  used_ = 0;
  const auto size = static_cast<std::size_t>(numbers);
  if (numbers_.size() < size) numbers_.resize(size);
}

double* ConeMemory::take(Index numbers) {
  double* out = numbers_.data() + used_;
  used_ += numbers;
  return out;
}

void DenseConeOperator::apply(const double* x, double* y) const {
  const Index n = G_.rows();
  Eigen::Map<Eigen::VectorXd>(y, n).noalias() = G_ * Eigen::Map<const Eigen::VectorXd>(x, n);
}

void DenseConeOperator::diagonal_block(const Cone& cone, double* out) const {
  const int n = cone.size();
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) out[i * n + j] = G_(cone.first + i, cone.first + j);
  }
}

double lift_of(const Cone& cone, const double* u) {
  double out = 0;
  for (const ConeGroup& group : cone.limited()) {
    double square = 0;
    for (int i = cone.first + group.offset; i < cone.first + group.offset + group.size; ++i) square += u[i] * u[i];
    out += group.coefficient * std::sqrt(square);
  }
  return out;
}

void add_lift(std::span<const Cone> cones, const double* u, double* out) {
  for (const Cone& cone : cones) {
    if (!cone.interval && !cone.is_ball) out[cone.first] += lift_of(cone, u);
  }
}

void ConeIteration::check() const {
  int next = 0;
  for (std::size_t i = 0; i < cones_.size(); ++i) {
    const Cone& cone = cones_[i];
    if (cone.first != next || !valid(cone)) {
      throw std::invalid_argument("cone " + std::to_string(i) +
                                  ": expected the unknown after those of the cone before it, non-negative coefficients "
                                  "and lower <= upper");
    }
    next += cone.size();
  }
  if (next != size_ || problem_->b.size() != static_cast<std::size_t>(size_)) {
    throw std::invalid_argument("the cones have " + std::to_string(next) + " unknowns and b has " +
                                std::to_string(problem_->b.size()) + ", expected " + std::to_string(size_));
  }
}

void ConeIteration::take_memory() {
  constexpr Index vectors = 9;
  memory_.start(vectors * size_);
  for (double** piece : {&d_, &b_, &x_, &u_, &start_x_, &best_x_, &best_u_, &work_, &unscaled_}) {
    *piece = memory_.take(size_);
  }
}

// Groups whose diagonal is zero, up to rounding, get the scale of the cone's other groups, or that of the stiffest
// cone.
void ConeIteration::set_up_scales() {
  std::array<double, Cone::max_block> block{};
  double largest = 0;
  for (const Cone& cone : cones_) {
    problem_->G.diagonal_block(cone, block.data());
    const auto n = static_cast<std::size_t>(cone.size());
    double* diagonal = d_ + cone.first;
    for (std::size_t i = 0; i < n; ++i) {
      diagonal[i] = block[i * n + i];
      largest = std::max(largest, diagonal[i]);
    }
  }
  if (!(largest > 0)) largest = 1;
  const auto scale = [&](double* diagonal, int size, double fallback) {
    double sum = 0;
    for (int i = 0; i < size; ++i) sum += diagonal[i];
    const double mean = sum > 0 && sum > size * epsilon * epsilon * largest ? sum / size : fallback;
    std::fill_n(diagonal, size, 1 / std::sqrt(mean));
    return mean;
  };
  for (Cone& cone : cones_) {
    double* d = d_ + cone.first;
    const int forces = cone.forces();
    const double mean = scale(d, forces, largest);
    scale(d + forces, cone.spin, mean);
    scale(d + forces + cone.spin, cone.roll, mean);
    if (cone.spin > 0) cone.spinning *= d[0] / d[forces];
    if (cone.roll > 0) cone.rolling *= d[0] / d[forces + cone.spin];
    cone.lower /= d[0];
    cone.upper /= d[0];
    cone.radius /= d[0];
  }
}

void ConeIteration::start(const ConeProblem& problem, const ConeOptions& options, double* x) {
  problem_ = &problem;
  options_ = &options;
  out_ = x;
  size_ = problem.G.size();
  matrix_formed_ = false;
  result_ = {};
  result_.residual = std::numeric_limits<double>::infinity();
  cones_.assign(problem.cones.begin(), problem.cones.end());
  check();
  take_memory();
  set_up_scales();
  for (Index i = 0; i < size_; ++i) {
    b_[i] = d_[i] * problem.b[static_cast<std::size_t>(i)];
    x_[i] = x[i] / d_[i];
  }
  start_residual_ = std::numeric_limits<double>::infinity();
  if (!all_finite(b_, size_) || !all_finite(x_, size_)) {
    result_.iterations = options.max_iterations;  // nothing to be done
    return;
  }
  project_all(x_, x_);
  update_velocity();
  keep();
  start_residual_ = residual_;
  if (options.observer) options.observer->reached(result_);
  std::copy_n(x_, size_, start_x_);
}

// x <- P_K(x). Returns whether it changed by more than rounding; u is then computed again.
bool ConeIteration::project_iterate() {
  double change = 0;
  double largest = 0;
  project_all(x_, work_);
  for (Index i = 0; i < size_; ++i) {
    change = std::max(change, std::abs(x_[i] - work_[i]));
    largest = std::max(largest, std::abs(x_[i]));
  }
  std::copy_n(work_, size_, x_);
  if (!(change > 4 * epsilon * largest)) return false;
  update_velocity();
  return true;
}

ConeResult ConeIteration::finish() {
  if (!std::isfinite(result_.residual)) return result_;
  return_to(Iterate::best);
  if (project_iterate()) {
    result_.residual = present_residual();
    result_.converged = result_.residual <= std::max(options_->tolerance, rounding());
  }
  const bool worse = !(result_.residual <= start_residual_);
  if (worse) result_.residual = start_residual_;
  const double* x = worse ? start_x_ : x_;
  for (Index i = 0; i < size_; ++i) out_[i] = d_[i] * x[i];
  return result_;
}

void ConeIteration::multiply(const double* in, double* out) {
  for (Index i = 0; i < size_; ++i) unscaled_[i] = d_[i] * in[i];
  problem_->G.apply(unscaled_, out);
  for (Index i = 0; i < size_; ++i) out[i] *= d_[i];
  ++result_.products;
}

void ConeIteration::project_all(const double* in, double* out) const {
  for (const Cone& cone : cones_) project(cone, in + cone.first, out + cone.first);
}

void ConeIteration::update_velocity() {
  multiply(x_, u_);
  u() += b();
}

Eigen::Map<const Eigen::MatrixXd> ConeIteration::matrix() {
  if (const double* dense = problem_->G.dense()) return {dense, size_, size_};
  if (!matrix_formed_) {
    formed_.start(size_ * size_);
    formed_matrix_ = formed_.take(size_ * size_);
    std::fill_n(work_, size_, 0.0);
    for (Index j = 0; j < size_; ++j) {
      work_[j] = 1;
      problem_->G.apply(work_, formed_matrix_ + j * size_);
      ++result_.products;
      work_[j] = 0;
    }
    matrix_formed_ = true;
  }
  return {formed_matrix_, size_, size_};
}

double ConeIteration::present_residual() {
  for (Index i = 0; i < size_; ++i) work_[i] = x_[i] - u_[i];
  if (exact()) {
    std::fill_n(unscaled_, size_, 0.0);
    add_lift(cones_, u_, unscaled_);
    for (Index i = 0; i < size_; ++i) work_[i] -= unscaled_[i];
  }
  project_all(work_, work_);
  double largest = 0;
  for (const Cone& cone : cones_) {
    double sum = 0, size = 0;
    for (int i = cone.first; i < cone.first + cone.size(); ++i) {
      sum += (x_[i] - work_[i]) * (x_[i] - work_[i]);
      size = std::max(size, std::abs(x_[i]));
    }
    // Where impulses grow without bound, their rounding hides the velocities.
    const double residual = std::max(std::sqrt(sum), 0.5 * epsilon * size) / d_[cone.first];
    if (!(residual <= largest)) largest = residual;  // NaN, too
  }
  return largest;
}

// What rounding leaves of the residual at a solution. Redundant impulses may be larger than the velocities that they
// cause, but impulses that grow without any effect do not make a solution.
double ConeIteration::rounding() const {
  constexpr double most_redundant = 1e3;
  double velocity = 0, impulse = 0;
  for (const Cone& cone : cones_) {
    for (int i = cone.first; i < cone.first + cone.size(); ++i) {
      velocity = std::max(velocity, (std::abs(b_[i]) + std::abs(u_[i])) / d_[cone.first]);
      impulse = std::max(impulse, std::abs(x_[i]) / d_[cone.first]);
    }
  }
  return 8 * epsilon * (velocity + std::min(impulse, most_redundant * velocity));
}

// Iterates outside K, of Newton's method, are projected before they count as solutions.
bool ConeIteration::keep() {
  residual_ = present_residual();
  if (!(residual_ < result_.residual)) return false;
  if (residual_ <= std::max(options_->tolerance, rounding()) && project_iterate()) residual_ = present_residual();
  if (!(residual_ < result_.residual)) return false;
  result_.residual = residual_;
  result_.converged = residual_ <= std::max(options_->tolerance, rounding());
  std::copy_n(x_, size_, best_x_);
  std::copy_n(u_, size_, best_u_);
  return true;
}

bool ConeIteration::advance(bool look) {
  ++result_.iterations;
  if (!look) return !done();
  keep();
  if (options_->observer) options_->observer->reached(result_);
  return !done();
}

void ConeIteration::return_to(Iterate which) {
  std::copy_n(which == Iterate::best ? best_x_ : start_x_, size_, x_);
  if (which == Iterate::start) return update_velocity();
  std::copy_n(best_u_, size_, u_);
}

ConeResult IterativeConeSolver::solve(const ConeProblem& problem, const ConeOptions& options, double* x) {
  iteration_.start(problem, options, x);
  reserve(iteration_);
  if (!iteration_.done()) run(iteration_);
  return iteration_.finish();
}

}  // namespace gelenk
