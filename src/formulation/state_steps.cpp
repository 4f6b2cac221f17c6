// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/state_steps.h"

#include <cmath>

namespace gelenk {
namespace {

// Changes of the states, relative to 1 and their size: that ends Newton's method, and by which rates are
// differentiated.
constexpr double newton_tolerance = 1e-12;
constexpr double relative_step = 1e-7;
constexpr int most_iterations = 30;

}  // namespace

StateSteps::StateSteps(Dynamics& dynamics, Drives& drives, int states)
    : dynamics_(dynamics),
      drives_(drives),
      middle_(states),
      residual_(states),
      rates_(states),
      displaced_(states),
      J_(states, states),
      lu_(states) {}

void StateSteps::rates(const Eigen::VectorXd& at) {
  drives_.set_states(at.data());
  dynamics_.readings().state_rates(drives_.u().data(), rates_.data());
}

bool StateSteps::find_middle(const double* z, double h) {
  const Eigen::Index n = middle_.size();
  const Eigen::Map<const Eigen::VectorXd> start(z, n);
  middle_ = start;
  for (int i = 0; i < most_iterations; ++i) {
    rates(middle_);
    residual_ = middle_ - start - h / 2 * rates_;
    J_.setIdentity();
    displaced_ = middle_;
    for (Eigen::Index k = 0; k < n; ++k) {
      const double step = relative_step * (1 + std::abs(middle_[k]));
      displaced_[k] += step;
      rates(displaced_);
      J_.col(k) += (displaced_ - start - h / 2 * rates_ - residual_) / step - Eigen::VectorXd::Unit(n, k);
      displaced_[k] = middle_[k];
    }
    lu_.compute(J_);
    displaced_ = lu_.solve(residual_);
    if (!displaced_.allFinite()) return false;
    middle_ -= displaced_;
    const double change = (displaced_.array().abs() / (1 + middle_.array().abs())).maxCoeff();
    drives_.set_states(middle_.data());
    if (change <= newton_tolerance) return true;
  }
  return false;
}

void StateSteps::finish(double* z) const {
  for (Eigen::Index k = 0; k < middle_.size(); ++k) z[k] = 2 * middle_[k] - z[k];
}

}  // namespace gelenk
