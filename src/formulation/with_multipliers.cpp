// SPDX-License-Identifier: BSD-3-Clause
#include "formulation/with_multipliers.h"

#include <algorithm>

namespace gelenk {
namespace {

// Relative to the largest pivot ratio at a start: below it a failure is attributed to a singular configuration.
constexpr double near_singular_fraction = 0.1;

}  // namespace

WithMultipliers::WithMultipliers(std::string_view name, const FormulationContext& context)
    : Formulation(context),
      name_(name),
      position_rows_(mechanism_.position_rows()),
      M_(mechanism_.nv, mechanism_.nv),
      f_(mechanism_.nv) {}

bool WithMultipliers::consistent(double t, double* x, double* xdot) {
  std::fill(x + size(), x + unknowns(), 0.0);
  std::fill(xdot + size(), xdot + unknowns(), 0.0);
  if (!rhs(t, x, xdot) || dynamics_.rank() < mechanism_.rows) return false;
  best_pivot_ratio_ = std::max(best_pivot_ratio_, dynamics_.pivot_ratio());
  dynamics_.set_acceleration(xdot + mechanism_.nq);
  std::ranges::copy(dynamics_.lambda(), x + size());
  return true;
}

std::string WithMultipliers::obstacle(const double* y) {
  if (!Eigen::Map<const Eigen::VectorXd>(y, size()).allFinite()) return {};
  if (std::string reason = Formulation::obstacle(y); !reason.empty()) return reason;
  dynamics_.factorize();
  const std::string advice = ", but the formulation " + name_ + " requires independent ones; use projection instead";
  if (dynamics_.rank() < mechanism_.rows) {
    return "the loops have " + std::to_string(mechanism_.rows) + " constraint equations of rank " +
           std::to_string(dynamics_.rank()) + advice;
  }
  if (dynamics_.pivot_ratio() < near_singular_fraction * best_pivot_ratio_) {
    return "close to a singular configuration, where the constraint equations of the loops become dependent" + advice;
  }
  return {};
}

void WithMultipliers::serialize(Archive& archive) {
  Formulation::serialize(archive);
  archive.serialize(best_pivot_ratio_);
}

bool WithMultipliers::assemble(double t, const double* x) {
  if (!Eigen::Map<const Eigen::VectorXd>(x, unknowns()).allFinite()) return false;
  drives_.go_to(t, x);
  dynamics_.set_position(x);
  dynamics_.set_velocity(x + mechanism_.nq);
  dynamics_.assemble(drives_.u().data(), M_.data(), f_.data());
  return f_.allFinite();
}

bool WithMultipliers::equations_of_motion(double t, const double* x, const double* xdot, Vector& r) {
  if (!assemble(t, x)) return false;
  dynamics_.qdot_from_v(x, x + mechanism_.nq, r.data());
  for (int i = 0; i < mechanism_.nq; ++i) r[i] = xdot[i] - r[i];
  const Eigen::Map<const Eigen::VectorXd> vdot(xdot + mechanism_.nq, mechanism_.nv);
  const Eigen::Map<const Eigen::VectorXd> lambda(x + size(), mechanism_.rows);
  auto balance = r.segment(mechanism_.nq, mechanism_.nv);
  balance = -f_;
  balance.noalias() += M_ * vdot;
  if (mechanism_.rows > 0) balance.noalias() += dynamics_.J().transpose() * lambda;
  if (drives_.states() == 0) return true;
  double* const rates = r.data() + drives_.motion_size();
  dynamics_.readings().state_rates(drives_.u().data(), rates);
  add_rates_of_forces(t, x, nullptr, rates);
  for (int k = 0; k < drives_.states(); ++k) rates[k] = xdot[drives_.motion_size() + k] - rates[k];
  return true;
}

bool WithMultipliers::motion_jacobian(double t, const double* x, const double* xdot, Matrix& F_x, Matrix& F_xdot) {
  count_jacobian();
  Eigen::MatrixXd by_differences;  // of rates that name forces
  if (rates_of_forces().any()) {
    by_differences.resize(drives_.states(), size());
    if (!differentiate_by_differences(t, x, nullptr, drives_.motion_size(), by_differences)) return false;
  }
  if (!assemble(t, x)) return false;
  dynamics_.differentiate(drives_.u().data(), drives_.count(), xdot + mechanism_.nq, jacobians_, x + size());
  F_x.setZero();
  F_x.topLeftCorner(mechanism_.nq, mechanism_.nq) = -jacobians_.qdot_q;
  F_x.block(0, mechanism_.nq, mechanism_.nq, mechanism_.nv) = -jacobians_.qdot_v;
  F_x.block(mechanism_.nq, 0, mechanism_.nv, mechanism_.nq) = jacobians_.r_q();
  F_x.block(mechanism_.nq, mechanism_.nq, mechanism_.nv, mechanism_.nv) = jacobians_.r_v();
  if (mechanism_.rows > 0) F_x.block(mechanism_.nq, size(), mechanism_.nv, mechanism_.rows) = dynamics_.J().transpose();
  if (drives_.states() > 0) {
    F_x.block(mechanism_.nq, drives_.motion_size(), mechanism_.nv, drives_.states()) =
        jacobians_.r_u.middleCols(drives_.first_state(), drives_.states());
    auto rates = F_x.middleRows(drives_.motion_size(), drives_.states());
    jacobians_.put_rates(drives_.first_state(), rates);
    if (by_differences.size() > 0) rates.leftCols(size()) = by_differences;
    rates = -rates;
  }
  F_xdot.setZero();
  F_xdot.block(drives_.motion_size(), drives_.motion_size(), drives_.states(), drives_.states()).setIdentity();
  F_xdot.topLeftCorner(mechanism_.nq, mechanism_.nq).setIdentity();
  F_xdot.block(mechanism_.nq, mechanism_.nq, mechanism_.nv, mechanism_.nv) = M_;
  return F_x.allFinite();
}

}  // namespace gelenk
