// SPDX-License-Identifier: BSD-3-Clause
#include "time_stepping/load_iteration.h"

#include <algorithm>
#include <cmath>

#include "linear/dense_factor.h"
#include "math/bounds.h"

namespace gelenk {
namespace {

// Iterations for the limits, and the relative change at which they end: far below what a step misses.
constexpr int most_iterations = 60;
constexpr double tolerance = 1e-10;
// Change of an iteration relative to the one before it, from which on others than this fixed point may be near.
constexpr double contraction = 0.5;
// Parts of the friction in which a motion is followed from that without friction.
constexpr int parts = 16;
constexpr int most_corrections = 10;
// Relative change of limits by which derivatives are taken: far more than what impulses miss, of which users permit
// some 1e-6.
constexpr double difference = 1e-3;
constexpr double least_pivot = 1e-300;

double largest_of(const std::vector<double>& of) {
  double out = 0;
  for (const double x : of) out = std::max(out, std::abs(x));
  return out;
}

double change_between(const std::vector<double>& a, const std::vector<double>& b) {
  double out = 0;
  for (std::size_t i = 0; i < a.size(); ++i) out = std::max(out, std::abs(a[i] - b[i]));
  return out;
}

}  // namespace

// found <- F of the present limits, of which those that are followed count by part_.
bool LoadIteration::evaluate(std::vector<double>& found) {
  if (!friction_->respond(*limits_, found)) return false;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const bool is_followed = kinds_[i] == Limit::of_motion || (follows_all_ && kinds_[i] == Limit::of_rest);
    if (is_followed) found[i] *= part_;
  }
  return std::ranges::all_of(found, [](double limit) { return std::isfinite(limit); });
}

// The first two iterations are not accelerated: they show whether the fixed point attracts.
bool LoadIteration::iterate() {
  std::vector<double>& limits = *limits_;
  const auto n = static_cast<Eigen::Index>(limits.size());
  acceleration_.start(n);
  contracts_ = true;
  double before = 0;
  for (int k = 0; k < most_iterations; ++k) {
    if (!evaluate(found_)) return false;
    const double change = change_between(found_, limits);
    if (change <= tolerance * largest_of(found_)) return true;
    if (!std::isfinite(change)) {  // the limits were those of what is held by any force
      limits = found_;
      continue;
    }
    if (k > 0 && k < 3 && before > 0) contracts_ = contracts_ && change <= contraction * before;
    before = change;
    if (k < 2) {
      limits = found_;
      continue;
    }
    const Eigen::Map<Eigen::VectorXd> now(limits.data(), n);
    const Eigen::Map<const Eigen::VectorXd> image(found_.data(), n);
    const AndersonAcceleration::Vector& next = acceleration_.next(now, image);
    std::copy_n(next.data(), limits.size(), limits.begin());
  }
  return false;
}

// matrix_ <- factors of the derivative of y - F(y) at the present limits, with F there in found_; only limits that
// friction has reached have an effect. Its determinant is positive on the branch that begins without friction.
LoadIteration::Branch LoadIteration::differentiate() {
  std::vector<double>& limits = *limits_;
  reached_.clear();
  friction_->add_reached(reached_);
  const auto n = static_cast<Eigen::Index>(reached_.size());
  matrix_.resize(reached_.size() * reached_.size());
  pivots_.resize(reached_.size());
  DenseMatrix derivative(matrix_.data(), n, n);
  const double largest = std::max(largest_of(limits), largest_of(found_));
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto at = static_cast<std::size_t>(reached_[static_cast<std::size_t>(j)]);
    const double before = limits[at];
    const double step = difference * std::max(before, difference * largest);
    limits[at] = before + step;
    const bool is_known = evaluate(changed_);
    limits[at] = before;
    if (!is_known) return Branch::unknown;
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto row = static_cast<std::size_t>(reached_[static_cast<std::size_t>(i)]);
      derivative(i, j) = (i == j ? 1 : 0) - (changed_[row] - found_[row]) / step;
    }
  }
  factorize_general(derivative, pivots_.data(), least_pivot);
  return has_positive_determinant(derivative, pivots_.data()) ? Branch::first : Branch::other;
}

bool LoadIteration::is_on_first_branch() {
  return differentiate() == Branch::first && evaluate(found_);  // which brings the step back to the present limits
}

// Newton's method from limits nearby.
bool LoadIteration::correct() {
  std::vector<double>& limits = *limits_;
  for (int k = 0; k < most_corrections; ++k) {
    if (!evaluate(found_)) return false;
    const double change = change_between(found_, limits);
    if (change <= tolerance * largest_of(found_)) return is_on_first_branch();
    if (!std::isfinite(change)) {
      limits = found_;
      continue;
    }
    if (differentiate() == Branch::unknown) return false;
    const auto n = static_cast<Eigen::Index>(reached_.size());
    correction_.resize(reached_.size());
    for (std::size_t i = 0; i < reached_.size(); ++i) {
      const auto at = static_cast<std::size_t>(reached_[i]);
      correction_[i] = found_[at] - limits[at];
      found_[at] = limits[at];
    }
    solve_general(DenseMatrix(matrix_.data(), n, n), pivots_.data(), DenseVector(correction_.data(), n));
    limits = found_;
    for (std::size_t i = 0; i < reached_.size(); ++i) limits[static_cast<std::size_t>(reached_[i])] += correction_[i];
  }
  return false;
}

void LoadIteration::hold_what_rests() {
  for (std::size_t i = 0; i < limits_->size(); ++i) {
    if (kinds_[i] == Limit::of_rest) (*limits_)[i] = unlimited;
  }
}

// From the motion without friction of what slides; what rests is held by what its friction can exert, or moves as well.
bool LoadIteration::follow(From what_rests) {
  follows_all_ = what_rests == From::motion;
  std::ranges::fill(*limits_, 0.0);
  if (!follows_all_) hold_what_rests();
  bool found = true;
  for (int k = 1; k <= parts && found; ++k) {
    part_ = static_cast<double>(k) / parts;
    found = correct();
  }
  follows_all_ = false;
  part_ = 1;
  return found;
}

// Everything at rest at the end of the step that can be.
bool LoadIteration::stop() {
  std::ranges::fill(*limits_, unlimited);
  return settle_regularly();
}

bool LoadIteration::settle(Friction& friction, std::span<const Limit> kinds, Holding holding,
                           std::vector<double>& limits) {
  friction_ = &friction;
  kinds_ = kinds;
  limits_ = &limits;
  found_.resize(limits.size());
  guess_ = limits;
  if (holding == Holding::by_any_force) hold_what_rests();
  if (settle_regularly() && !friction_->stops()) return true;
  if (holding == Holding::in_impact) {
    if (follow(From::motion)) return true;
    limits = guess_;  // what has no motion after the impact stops in the next step
    return evaluate(found_);
  }
  const bool any_rests = std::ranges::find(kinds_, Limit::of_rest) != kinds_.end();
  return (any_rests && follow(From::rest)) || follow(From::motion) || stop();
}

}  // namespace gelenk
