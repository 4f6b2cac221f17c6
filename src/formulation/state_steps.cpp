// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/state_steps.h"

#include <cmath>
#include <numbers>

namespace gelenk {
namespace {

// Changes of the states, relative to 1 and their size: that ends Newton's method, and by which rates are
// differentiated.
constexpr double newton_tolerance = 1e-12;
constexpr double relative_step = 1e-7;
constexpr int most_newton_steps = 30;
constexpr double gamma = 1 - 1 / std::numbers::sqrt2;  // of the method

}  // namespace

StateSteps::StateSteps(Dynamics& dynamics, Drives& drives, int states)
    : dynamics_(dynamics),
      drives_(drives),
      z_(states),
      stage_(states),
      residual_(states),
      rates_(states),
      displaced_(states),
      J_(states, states),
      lu_(states) {}

void StateSteps::rates(const Eigen::VectorXd& at) {
  drives_.set_states(at.data());
  dynamics_.readings().state_rates(drives_.u().data(), rates_.data());
}

// Solves stage_ = from + h f(stage_) by Newton's method; rates_ <- f there. Where that has no solution, as where a rate
// jumps, or no derivative, it is the explicit step.
bool StateSteps::solve(const Eigen::VectorXd& from, double h) {
  stage_ = from;
  for (int i = 0; i < most_newton_steps; ++i) {
    rates(stage_);
    residual_ = stage_ - from - h * rates_;
    J_.setIdentity();
    displaced_ = stage_;
    for (Eigen::Index k = 0; k < stage_.size(); ++k) {
      const double step = relative_step * (1 + std::abs(stage_[k]));
      displaced_[k] += step;
      rates(displaced_);
      J_.col(k) += (displaced_ - from - h * rates_ - residual_) / step;
      J_(k, k) -= 1;
      displaced_[k] = stage_[k];
    }
    lu_.compute(J_);
    displaced_ = lu_.solve(residual_);
    if (!displaced_.allFinite()) break;
    stage_ -= displaced_;
    const double change = (displaced_.array().abs() / (1 + stage_.array().abs())).maxCoeff();
    if (change > newton_tolerance) continue;
    rates(stage_);
    return rates_.allFinite();
  }
  rates(from);
  stage_ = from + h * rates_;
  return stage_.allFinite();
}

bool StateSteps::predict_middle(const double* z, double h) {
  z_ = Eigen::Map<const Eigen::VectorXd>(z, z_.size());
  if (!solve(z_, h / 2)) return false;
  drives_.set_states(stage_.data());
  return true;
}

bool StateSteps::advance(double* z, double h) {
  Eigen::Map<Eigen::VectorXd> to(z, z_.size());
  z_ = to;
  if (!solve(z_, gamma * h)) return false;
  z_ += (1 - gamma) * h * rates_;
  if (!solve(z_, gamma * h)) return false;
  to = stage_;
  return true;
}

}  // namespace gelenk
