// SPDX-License-Identifier: BSD-3-Clause
// Time derivatives along the motion: the part of ConstrainedSensitivity that uses power series.
#include "analysis/constrained_sensitivity_impl.h"
#include "analysis/dual_columns.h"
#include "kinematics/loads.h"
#include "mechanism/mechanism.h"

namespace gelenk {

using Eigen::Index;
using Eigen::VectorXd;

CarriedState<Series>& ConstrainedSensitivity::time_derivatives(const double* udot, const double* uddot) {
  begin(series_state_);
  ResidualEvaluator<Series>& e = *series_state_.equations;
  const int given = inputs_ - loads_.states();
  for (int i = 0; i < given; ++i) series_state_.u[i] = Series({u_[i], udot[i], uddot[i] / 2});
  std::vector<Series> rates(rates_.begin(), rates_.end());
  for (int i = given; i < inputs_; ++i) series_state_.u[i] = Series(u_[i]);
  expand_targets(udot, uddot);
  if (redundant_) set_values(x_, x_in_time_);
  holding_in_time_.assign(holding_.begin(), holding_.end());
  if (rates_of_forces_) {
    e.set_position(series_state_.q.data());
    e.set_velocity(series_state_.v.data());
    find_rates(rates);
  }
  // If q and v are known to order k - 1, qdot = N v and vdot give them to order k, and the residuals give vdot and
  // lambda.
  for (int k = 1; k <= series_order; ++k) {
    for (int i = 0; i < mechanism_.nv; ++i) series_state_.v[i][k] = series_state_.vdot[i][k - 1] / k;
    e.set_position(series_state_.q.data());
    e.set_velocity(series_state_.v.data());
    for (int i = 0; i < mechanism_.nq; ++i) series_state_.q[i][k] = e.qdot()[i][k - 1] / k;
    e.set_position(series_state_.q.data());
    for (std::size_t i = 0; i < rates.size(); ++i) series_state_.u[given + i][k] = rates[i][k - 1] / k;
    if (loads_.motions_follow_signals()) expand_targets(udot, uddot);
    expand_acceleration(k);
    find_rates(rates);
  }
  if (dynamics_->switching_forces().is_redundant()) {
    for (std::vector<Series>* of : {&series_state_.lambda, &holding_in_time_}) {
      for (Series& x : *of) {
        for (int k = 1; k <= series_order; ++k) x[k] = undetermined;
      }
    }
  }
  e.set_velocity(series_state_.v.data());
  e.set_acceleration(series_state_.u.data(), series_state_.vdot.data(), series_state_.lambda.data());
  set_forces(series_state_, holding_in_time_);
  return series_state_;
}

// Those of the element states, to the order to which the accelerations are known.
void ConstrainedSensitivity::find_rates(std::vector<Series>& rates) {
  ResidualEvaluator<Series>& e = *series_state_.equations;
  if (!rates_of_forces_) return e.state_rates(series_state_.u.data(), rates.data());
  e.set_acceleration(series_state_.u.data(), series_state_.vdot.data(), series_state_.lambda.data());
  set_forces(series_state_, holding_in_time_);
  rates = rates_of_forces_(series_state_);
}

// Targets given by inputs have the inputs' time derivatives; those that follow signals are expressions of these.
void ConstrainedSensitivity::expand_targets(const double* udot, const double* uddot) {
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    mechanism_.coordinate_rows[i].for_inputs([&](int input, int order) {
      const auto of = static_cast<std::size_t>(order);
      targets_[i][of + 1] = udot[input];
      targets_[i][of + 2] = uddot[input];
    });
  }
  set_targets(series_state_, [&](std::size_t i, int order) {
    const MotionLaw::Derivatives& s = targets_[i];
    if (mechanism_.coordinate_rows[i].follows_signals)
      return loads_.motion(i, static_cast<std::size_t>(order), series_state_.u.data());
    return Series({s[order], s[order + 1], s[order + 2] / 2});
  });
}

// Computes vdot and lambda to order k from q and v to that order.
void ConstrainedSensitivity::expand_acceleration(int k) {
  ResidualEvaluator<Series>& e = *series_state_.equations;
  VectorXd projected_rates = VectorXd::Zero(mechanism_.rows);
  if (redundant_) {
    const std::vector<Series> targets = series_state_.targets;
    set_targets(series_state_, [](std::size_t, int) { return Series(0); });
    e.set_velocity(x_in_time_.data());
    projected_rates = derivatives_along(e.row_rates(), k);
    series_state_.targets = targets;
    e.set_targets(series_state_.targets.data());
  }
  e.set_velocity(series_state_.v.data());
  e.set_acceleration(series_state_.u.data(), series_state_.vdot.data(), series_state_.lambda.data());
  VectorXd r = derivatives_along(e.force_residual(), k);
  VectorXd l;
  VectorXd holding;
  solve(r, derivatives_along(e.acceleration_residual(), k), l, holding);
  if (redundant_) {
    l += null_multipliers_ * projected_rates;
    const VectorXd x = inverse_ * (l - projected_rates);
    for (Index i = 0; i < x.size(); ++i) x_in_time_[i][k] = x[i];
  }
  for (Index i = 0; i < r.size(); ++i) series_state_.vdot[i][k] = r[i];
  for (Index i = 0; i < l.size(); ++i) series_state_.lambda[i][k] = l[i];
  for (Index i = 0; i < holding.size(); ++i) holding_in_time_[static_cast<std::size_t>(i)][k] = holding[i];
}

}  // namespace gelenk
