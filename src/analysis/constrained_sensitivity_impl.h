// SPDX-License-Identifier: BSD-3-Clause
// The parts of ConstrainedSensitivity that dual numbers and power series share.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include "analysis/constrained_sensitivity.h"

namespace gelenk {

inline constexpr double undetermined = std::numeric_limits<double>::quiet_NaN();

// The derivatives of multipliers and holding forces that balance redundant forces of contacts become not a number.
// respond(r, l, x): those that balance the generalized forces -r.
using Response = std::function<void(Eigen::VectorXd& r, Eigen::VectorXd& l, Eigen::VectorXd& x)>;
void undetermine_reactions(const HeldContacts& contacts, const Response& respond, Eigen::MatrixXd& dlambda,
                           std::vector<Dual>& holding);

// Throws NotDifferentiablePoint if redundant forces of contacts change the derivatives of the accelerations, which
// accelerations() returns for the present forces.
void require_determined_prestress(HeldContacts& contacts, const std::function<Eigen::MatrixXd()>& accelerations);

// Sets `at` to the point without derivatives.
template <class T>
void ConstrainedSensitivity::begin(CarriedState<T>& at) {
  at.q.assign(q_.begin(), q_.end());
  at.v.assign(v_.begin(), v_.end());
  at.u.assign(u_.begin(), u_.end());
  at.vdot.assign(vdot_.begin(), vdot_.end());
  at.lambda.assign(lambda_.begin(), lambda_.end());
  at.equations->set_cut_reference(cut_q_.data());
}

// target(row, order): target of a coordinate row or its time derivative of that order.
template <class T, class Target>
void ConstrainedSensitivity::set_targets(CarriedState<T>& at, Target target) {
  at.targets.clear();
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    for (int order = 0; order < 3; ++order) at.targets.push_back(target(i, order));
  }
  at.equations->set_targets(at.targets.data());
}

// Sets the forces of `at` from the holding forces, by lock.
template <class T>
void ConstrainedSensitivity::set_forces(CarriedState<T>& at, const std::vector<T>& holding) {
  if (sides_.empty()) return;
  std::vector<T> by_force(sides_.size());
  share_holding_forces(dynamics_->switching_forces(), sides_.data(), holding.data(), by_force.data());
  at.forces.resize(sides_.size());
  at.equations->switching_forces(at.equations->all_signals(at.u.data()), sides_.data(), by_force.data(),
                                 at.forces.data());
}

}  // namespace gelenk
